"""Settings that only a study has, next to those of the library."""

from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field

from sparsurf.arguments import share_of_plddt
from sparsurf.settings import (
    INTEGER,
    NUMBER_TYPES,
    CombinationSetting,
    Positive,
    Section,
    TestDots,
    key,
)
from sparsurf.settings import Settings as LibrarySettings

T = TypeVar("T")

Integer = Annotated[int, INTEGER]
Thousand = Annotated[int, Field(ge=1, le=1000), INTEGER]
FrameNumber = Annotated[int, Field(ge=0, le=10**9), INTEGER]


def _without_share(bound: float) -> float:
    if reason := share_of_plddt(bound):
        raise ValueError(reason)
    return bound


Plddt = Annotated[float, Field(ge=0, le=100), AfterValidator(_without_share), NUMBER_TYPES]
PercentBelow100 = Annotated[float, Field(gt=0, lt=100), NUMBER_TYPES]
Two = Annotated[list[T], Field(min_length=2, max_length=2)]


class Ensemble(Section):
    """One combination of the paper's sampling, evaluated on all frames of each trajectory."""

    run: bool = key(False, "Whether ensemble.csv and its figure are written.")
    combination: CombinationSetting = key(
        [1.0, 0.0, 6.0, 0.0], "alpha, beta, gamma and delta of the combination."
    )
    test_dots: TestDots = key(200, "Number of test dots of each frame; published: one for every 200 dots.")
    stride: Positive = key(
        1, "Evaluate every n-th frame of the file, independently of frames.stride, start and stop."
    )


class StudySettings(LibrarySettings):
    """The sections that the analysis of one surface of a study follows."""

    ensemble: Ensemble = Ensemble()


def name_in_config(argument: str) -> str:
    """Return the key of the config for an argument of the library: patches.d_link for d_link.

    An argument that no section has, or more than one, is called as in Python.
    """
    sections = []
    for name, field in StudySettings.model_fields.items():
        section = field.annotation
        if isinstance(section, type) and issubclass(section, Section) and argument in section.model_fields:
            sections.append(name)
    return f"{sections[0]}.{argument}" if len(sections) == 1 else argument
