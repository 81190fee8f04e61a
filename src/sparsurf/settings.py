"""Settings of the functions that compute: sections with a type, limits, a default and a meaning for each key.

The config of a study has the same sections (`sparsurf_study.settings` adds those that only a study has).
"""

import logging
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias, TypeVar, cast

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticKnownError

from sparsurf import arguments, registry
from sparsurf.arguments import Auto, Cavities, Model, RadiiTable, Reentrant

log = logging.getLogger("sparsurf")

# `minimal` takes exactly one of them
REQUEST_KEYS = ("error", "density", "percent", "n_dots", "max_z", "combination")

DEFAULT_ERROR = 0.02  # Å
TAIL_PER_ERROR = 5  # 99 % error over the mean error that is requested, with the sampler cover
# What decides the number of dots that are kept for an error, and how a person is told
BY_MEAN, BY_FORTH, BY_BACK, BY_FEWEST, BY_ALL = "mean", "99 % forth", "99 % back", "fewest", "all"
_TAIL = f"by default {TAIL_PER_ERROR} times the mean error, and a larger error_99 keeps fewer dots"
DECISIONS = {
    BY_MEAN: "The mean error decides how many dots are kept.",
    BY_FORTH: "The 99 % error decides how many dots are kept: 99 % of the true surface must lie within error_99 of the "
    f"reconstructed one, {_TAIL}.",
    BY_BACK: "The 99 % error decides how many dots are kept: 99 % of the reconstructed surface must lie within error_99 of the "
    f"true one, {_TAIL}.",
    BY_FEWEST: "The smallest number of dots from which a surface is reconstructed decides how many dots are kept: their error is "
    "smaller than requested.",
    BY_ALL: "No smaller subset meets the limit, and all dots are kept.",
}

T = TypeVar("T")
OR_INSTALLED = "or one of an installed package"  # after the names of a kind


def _as_integer(value: Any) -> Any:
    """Convert 3.0 to 3."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _as_written(value: Any, validate: Any) -> Any:
    """Check a number and keep it as it is: 2 stays an integer, 2.0 a float."""
    validate(value)
    return value


def _one_of(kind: str, built_in: bool = False) -> Any:
    """Return the type of a key that names one choice of a kind; its schema lists those of the library.

    Unless it must be `built_in`, names that installed packages add are taken as well.
    """

    def check(value: Any) -> Any:
        if isinstance(value, str) and (
            value in registry.TABLE[kind] or (not built_in and registry.has(kind, value))
        ):
            return value
        listed = [*registry.TABLE[kind]] if built_in else registry.names(kind)
        expected = ", ".join(map(repr, listed)) + ("" if built_in else f" {OR_INSTALLED}")
        raise PydanticKnownError("literal_error", {"expected": expected})

    schema = WithJsonSchema({"enum": [*registry.TABLE[kind]], "type": "string"})
    return Annotated[str, BeforeValidator(check), schema]


def without_repeats(values: list) -> list:
    """Refuse a list that holds a value twice."""
    if any(value in values[:k] for k, value in enumerate(values)):
        raise ValueError(f"holds a value twice: {values}; remove one of them.")
    return values


def _alpha_first(combination: list) -> list:
    if not 0 < combination[0] <= 1:
        raise ValueError(f"is {combination}, but its first number, alpha, must be more than 0 and 1 or less.")
    return combination


def _at_most_or_infinite(value: float) -> float:
    if not arguments.DISTANCE_OR_INFINITE.allow(value):
        raise ValueError(f"is {value}; it must be {arguments.DISTANCE_OR_INFINITE.words}.")
    return value


def _bounds(limits: arguments.Limits) -> dict[str, float]:
    """Return limits as pydantic names them."""
    return {"gt" if limits.open_low else "ge": limits.low, "le": limits.high}


INTEGER, NUMBER_TYPES = BeforeValidator(_as_integer), WrapValidator(_as_written)
if TYPE_CHECKING:  # for a type checker, a name is a string
    Sampler: TypeAlias = str
    Roughness: TypeAlias = str
    Descriptor: TypeAlias = str
    Reading: TypeAlias = str
else:
    Sampler, Roughness, Descriptor = map(_one_of, ("sampler", "roughness", "descriptor"))
    Reading = _one_of("reading", built_in=True)  # whose columns the tables of a study describe
Positive = Annotated[int, Field(ge=1, le=10**9), INTEGER]
Count = Annotated[int, Field(ge=1, le=10_000), INTEGER]
TestDots = Literal["published"] | Annotated[int, Field(**_bounds(arguments.TEST_DOTS)), INTEGER]
Number = Annotated[float, NUMBER_TYPES]
Alpha = Annotated[float, Field(**_bounds(arguments.ALPHA)), NUMBER_TYPES]
Exponent = Annotated[float, Field(**_bounds(arguments.EXPONENT)), NUMBER_TYPES]
Percent = Annotated[float, Field(**_bounds(arguments.PERCENT_LIMITS)), NUMBER_TYPES]
Length = Annotated[float, Field(**_bounds(arguments.LENGTH)), NUMBER_TYPES]  # Å
Distance = Annotated[float, Field(**_bounds(arguments.DISTANCE)), NUMBER_TYPES]  # Å
DistanceOrInfinite = Annotated[  # Å
    float, Field(gt=0, allow_inf_nan=True), AfterValidator(_at_most_or_infinite), NUMBER_TYPES
]
Density = Annotated[float, Field(**_bounds(arguments.DENSITY_LIMITS)), NUMBER_TYPES]  # dots per Å^2
Seed = Annotated[int, Field(**_bounds(arguments.SEED)), INTEGER]
UniqueList = Annotated[
    list[T],
    Field(min_length=1),
    AfterValidator(without_repeats),
    Field(json_schema_extra={"uniqueItems": True}),
]
ListOf = Annotated[UniqueList[T], Field(max_length=100)]
CombinationSetting = Annotated[
    list[Exponent], Field(min_length=4, max_length=4), AfterValidator(_alpha_first)
]


def key(default: Any, description: str, **limits: Any) -> Any:
    """Return a key with its default and meaning."""
    return Field(default, description=description, **limits)


def of_argument(name: str) -> Any:
    """Return the key of an argument of the same name, with its limits, default and meaning."""
    parameter = arguments.ARGUMENTS[name]
    meaning = f"{parameter.meaning[:1].upper()}{parameter.meaning[1:]}."
    return key(parameter.default, meaning, **_bounds(cast(arguments.Limits, parameter.allowed)))


def optional(description: str, **limits: Any) -> Any:
    """Return a key without a default: its attribute is None, and `model_dump` leaves it out."""
    return Field(None, description=description, **limits)


class Section(BaseModel):
    """A mapping of the config: unknown keys and values of other types are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)

    if not TYPE_CHECKING:  # else a type checker takes every name for a key

        def __getattr__(self, name: str) -> Any:
            """Refuse to read a key that a rule does not pass, see `Settings.of`: a default would stand in for the config."""
            if name not in type(self).model_fields:
                return super().__getattr__(name)
            section = (
                ""
                if isinstance(self, Settings)
                else f"{type(self).__name__.removesuffix('Settings').lower()}."
            )
            raise AttributeError(
                f"{section}{name} was read, but the rule of this job does not pass it; add it to the params of the rule"
            )

    def only(self, keys: Collection[str]) -> Self:
        """Return a copy with these keys, and those that are optional; reading another one is an error."""
        fields = type(self).model_fields
        copy = self.model_copy()
        for key in fields.keys() - set(keys):
            if fields[key].default is not None:
                del vars(copy)[key]
        return copy

    @model_validator(mode="after")
    def _defaults_as_written(self) -> "Section":
        """Replace 4 by the default 4.0: a default that is written out changes nothing."""
        for key in self.model_fields_set:
            default = type(self).model_fields[key].default
            if type(default) is float and getattr(self, key) == default:
                vars(self)[key] = default
        return self


class SurfaceSettings(Section):
    """How the molecular surface is computed."""

    probe_radius: Number = of_argument("probe_radius")
    density: Auto | Density = key(
        "auto",
        "Number of dots placed per Å^2; auto: 5.35, or more where a smaller d_link requires closer dots.",
    )
    radii: RadiiTable = key("dms", "Table of atomic radii: that of the program DMS, or that of Bondi.")
    cavities: Cavities = key(
        "keep",
        "Whether dots on the walls of closed cavities inside the molecule are kept; DMS and the paper keep them.",
    )
    reentrant: Reentrant = key(
        "exact",
        "Concave dots where the surface intersects itself: exact removes them, dms keeps them as the program DMS does.",
    )


class PatchesSettings(Section):
    """Radii of the patches, and the distance below which dots are linked."""

    r_patch: Number = of_argument("r_patch")
    r_zernike: Number = of_argument("r_zernike")
    d_link: Number = of_argument("d_link")
    roughness: Roughness = key(
        "published", "Definition of the roughness of a patch; published is that of the paper."
    )
    descriptor: Descriptor = key(
        "published",
        "Descriptor of a patch: that of the paper, or one that depends very little on the orientation of the molecule.",
    )


class SamplingSettings(Section):
    """The grid of combinations of alpha, beta, gamma and delta, and two rules of the paper's sampling."""

    run: bool = key(
        True, "Whether the paper's sampling is evaluated over the grid; `sampling: false` skips it."
    )
    alpha: ListOf[Alpha] = key(
        [0.1, 0.2, 0.4, 0.6, 0.8, 1.0], "Values of alpha, which scales the number of kept dots."
    )
    beta: ListOf[Exponent] = key(
        [0.0, 0.2, 0.4, 0.6, 0.8, 1.0],
        "Values of beta, which lowers the number of dots kept in flat patches.",
    )
    gamma: ListOf[Exponent] = key(
        [0, 2, 4, 6, 8, 10],
        "Values of gamma, which shifts the kept dots towards the rim of a patch, more so in flat patches.",
    )
    delta: ListOf[Exponent] = key(
        [0, 2, 4, 6, 8, 10], "Values of delta, which shifts the kept dots towards the rim of a patch."
    )
    distance_from_moved_centre: bool = key(
        True,
        "true, as published: distances are measured from the centre of a patch after it moved to the largest island; "
        "false: from the dot that started the patch.",
    )
    chance_in_every_patch: bool = key(
        True,
        "true, as published: a dot can be kept in each patch that contains it; false: it has one chance.",
    )


class Evaluation(Section):
    """How subsets are compared with the full surface."""

    test_dots: TestDots = key(
        arguments.DEFAULT_TEST_DOTS,
        "Number of dots at which the patches of a subset are compared with those of the full surface; published: one "
        "for every 200 dots.",
    )
    draws: Count = key(
        6,
        "Number of times that each combination is sampled, each time with a random subset of the same size.",
    )
    readings: UniqueList[Reading] = key(
        ["kept", "full"],
        "Readings: where dots outside of the largest island of a patch are removed. kept_scaled is measured for the best "
        "combination of each range only; recovered costs 0.04 CPU s more per sampling of 20,000 dots.",
    )

    @property
    def grid_readings(self) -> tuple[str, ...]:
        """The readings under which all combinations are evaluated."""
        return tuple(reading for reading in self.readings if reading != "kept_scaled")


class Minimal(Section):
    """The minimal subset of the dots; give at most one of error, density, percent, n_dots, max_z and combination."""

    sampler: Auto | Sampler = key(
        "auto",
        "Sampler that chooses the subset; auto: cover where an error of at most 0.12 Å is requested of dots on atoms, unless the "
        "reconstruction is interpolant; else farthest.",
    )
    reconstruction: Model = key(
        "auto",
        "How the surface is reconstructed from the subset: by the spheres that its dots lie on, or by the interpolant; auto: "
        "spheres with the sampler cover, and where the sampler auto keeps dots on atoms for an error; else the interpolant.",
    )
    error: Distance = optional(
        "Mean error in Å of the surface reconstructed from the subset, which keeps no more dots than its sampler needs for it. "
        f"{DEFAULT_ERROR:g} if no other of these keys is given; in batches, percent: 10 instead."
    )
    error_99: DistanceOrInfinite = optional(
        "Error in Å that at most 1 % of the true surface exceeds, besides the mean error; with the sampler cover also at most "
        f"1 % of the reconstructed surface, and {TAIL_PER_ERROR} times the mean error if it is not given; .inf: the mean error "
        "alone is bounded."
    )
    density: Density = optional(
        "Number of dots to keep per Å^2; 0.6 gives a mean error of about 0.02 Å by the interpolant."
    )
    percent: Number = of_argument("percent")
    n_dots: Positive = optional("Number of dots to keep.")
    max_z: Number = optional(
        "Largest acceptable Z under the reading `full`; no more dots are kept than the sampler needs for it.",
        ge=0,
    )
    combination: CombinationSetting = optional(
        "alpha, beta, gamma and delta of the paper's sampling, which is drawn once; the sampler is paper, unless "
        "paper_corrected is named."
    )

    @model_validator(mode="before")
    @classmethod
    def _takes_old_names(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and "model" in keys and "reconstruction" not in keys:
            keys = {"reconstruction" if key == "model" else key: value for key, value in keys.items()}
            log.warning(
                "minimal: write reconstruction: %s in place of model: %s, which version 8 will refuse.",
                *[keys["reconstruction"]] * 2,
            )
        return keys

    @model_validator(mode="after")
    def _has_one_request(self) -> "Minimal":
        requests = [key for key in REQUEST_KEYS if getattr(self, key) is not None]
        if len(requests) > 1:
            raise ValueError(
                f"takes only one of {', '.join(REQUEST_KEYS)}, but has {', '.join(requests)}; keep one of them."
            )
        if not requests:
            vars(self)["error"] = DEFAULT_ERROR
        if self.error_99 is not None and self.error is None:
            raise ValueError(f"takes error_99 with error only, but has {requests[0]}; remove one of them.")
        if self.combination is not None and "sampler" not in self.model_fields_set:
            vars(self)["sampler"] = "paper"
        return self


class Settings(Section):
    """The sections that computations on one surface follow."""

    surface: SurfaceSettings = SurfaceSettings()
    patches: PatchesSettings = PatchesSettings()
    sampling: SamplingSettings = SamplingSettings()
    evaluation: Evaluation = Evaluation()
    minimal: Minimal = Minimal()
    fields: list[str] = []

    @classmethod
    def of(cls, params: Mapping[str, Any]) -> Self:
        """Return the sections among the params of a rule, with the keys that the rule passes.

        Reading another section or key is an error, since a default would stand in for what the config says.
        """
        given = {key: value for key, value in params.items() if key in cls.model_fields}
        settings = cls(**given).only(given)
        sections = {key: value for key, value in vars(settings).items() if isinstance(value, Section)}
        return settings.model_copy(update={key: value.only(given[key]) for key, value in sections.items()})
