"""The language of the config: it is read strictly and checked, with one sentence for each mistake."""
