"""Calls of a function, for tests of what a script hands on."""


def noted(monkeypatch, module, name, instead=None):
    """Arguments of the calls of a function, the keywords last, in whose place another may do its work."""
    calls, work = [], instead or getattr(module, name)

    def note(*given, **keys):
        calls.append((*given, *keys.values()))
        return work(*given, **keys)

    monkeypatch.setattr(module, name, note)
    return calls
