"""Laws of the mesh that a user's force may follow in place of the arm's own."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any, NamedTuple, get_args

import numpy as np
from pydantic import ValidationError

from crosscheck.analytic.paper.stiffness import mean_stiffness
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.experiment.scenario import Switches
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.diagnose.terms import reference_terms as reference
from crosscheck.trial.diagnose.terms.explain import UNEXPLAINED, explain
from crosscheck.trial.diagnose.terms.harmonic_fit import HarmonicBasis, HarmonicFit, evaluate_entry
from crosscheck.trial.diagnose.terms.reference_terms import (
    USUAL,
    ForceStates,
    MeshConvention,
    ReferenceTerms,
)
from crosscheck.trial.diagnose.terms.values import collect_arm_values
from crosscheck.trial.judge.entries import EntryPlace, Explanation, Term, TermError

SIDES = {"sp": "sun_mesh", "pr": "ring_mesh"}
SWITCHED = ("phase", "ring_rate", "dead_zone", "damping", "mesh_work")
NEARLY = 1e-6  # largest residual of two laws worth a closer look, over the difference squared
MOST_EXPLANATIONS = 6


class ForceVariant(NamedTuple):
    """Another law that a user's force may follow: its arm, switches and convention.

    user_law, reference_law: what that law is, and in place of which; meshes: where, '' for all.
    """

    user_law: str
    reference_law: str
    meshes: str
    arm: Arm
    switches: Switches
    convention: MeshConvention = USUAL

    @property
    def error(self) -> TermError:
        """The other law as an error in a term."""
        of = "phase of mesh force" if self.convention.changes_phases else "mesh force"
        return TermError(
            "swapped", Term(f"{of} {self.meshes}".strip()), self.user_law, self.reference_law
        )


def _constant_stiffness(law: Any) -> SineStiffness:
    return SineStiffness(law="sine", mean_N_per_m=mean_stiffness(law), amplitude_N_per_m=0.0)


def _reverse_waves(law: Any) -> Any:
    """A stiffness whose amplitude has the opposite sign; other laws as they are."""
    if not isinstance(law, SineStiffness):
        return law
    return law.model_copy(update={"amplitude_N_per_m": -law.amplitude_N_per_m})


# Field, its change, and the words for the user's value and for the right one.
CHANGES: tuple[tuple[str, Callable[[Any], Any], str, str], ...] = (
    ("backlash_m", lambda b: 0.0, "backlash 0", "b"),
    ("backlash_m", lambda b: 2 * b, "2 b", "b"),
    ("backlash_m", lambda b: b / 2, "b/2", "b"),
    ("tooth_error_m", lambda e: 0.0, "no tooth error", "E"),
    ("tooth_error_m", lambda e: 2 * e, "2 E", "E"),
    ("tooth_error_phase_rad", lambda p: p + math.pi, "-E", "E"),
    ("tooth_error_phase_rad", lambda p: 0.0, "no phase of the tooth error", "its phase"),
    ("static_error_m", lambda e: 0.0, "no static error", "e_0"),
    ("static_error_m", lambda e: -e, "-e_0", "e_0"),
    ("stiffness", _constant_stiffness, "constant mean stiffness", "k over the mesh phase"),
    ("stiffness", _reverse_waves, "k with its amplitude of the opposite sign", "k"),
    ("phase_rad", lambda p: 0.0, "no phase_rad", "phase_rad"),
    ("phase_rad", lambda p: p if isinstance(p, str) else -p, "-phase_rad", "phase_rad"),
)


def generate_force_variants(arm: Arm, layout: Layout, chosen: Switches) -> Iterator[ForceVariant]:
    """Laws by other switches; by each change of all meshes, and of one; then by other phases."""
    for name in SWITCHED:
        chosen_value = getattr(chosen, name)
        for other in get_args(Switches.model_fields[name].annotation):
            try:
                switches = Switches.model_validate(chosen.model_dump() | {name: other})
            except ValidationError:  # two laws that do not go together
                continue
            if other != chosen_value:
                yield ForceVariant(
                    f"{name} = {other}", f"{name} = {chosen_value}", "", arm, switches
                )
    geared = [j for j, joint in enumerate(arm.joints) if isinstance(joint, Planetary)]
    single = [(joint, pair) for joint in geared for pair in SIDES]
    for field, change, user_law, reference_law in CHANGES:
        for where in (single, *([mesh] for mesh in single)) if len(single) > 1 else (single,):
            other_arm = _change_meshes(arm, where, field, change)
            if other_arm != arm:
                meshes = ", ".join(f"{pair}{joint + 1}" for joint, pair in where)
                yield ForceVariant(user_law, reference_law, meshes, other_arm, chosen)
    if chosen.dead_zone == "exact":
        yield from _contact_variants(arm, chosen)
    yield from _phase_variants(arm, layout, chosen)


def _contact_variants(arm: Arm, chosen: Switches) -> Iterator[ForceVariant]:
    """Laws with other branches; a damper that the spring limits acts in contact alone."""
    always, in_contact = (
        chosen.model_copy(update={"damping": damping}) for damping in ("always", "contact")
    )
    usual, other = f"damping = {chosen.damping}", always if chosen == in_contact else in_contact
    pushing, capped = MeshConvention(damper="pushing"), MeshConvention(damper="capped")
    by_x, of_x = MeshConvention(contact_by_x=True), "the gap asked of x"
    for user_law, reference_law, laws, convention in (
        ("a contact that never pulls", usual, in_contact, pushing),
        ("the damper capped at the spring's force", usual, in_contact, capped),
        (of_x, "x - e", chosen, by_x),
        (f"{of_x} (damping = {other.damping})", f"x - e ({usual})", other, by_x),
    ):
        yield ForceVariant(user_law, reference_law, "", arm, laws, convention)


def _phase_variants(arm: Arm, layout: Layout, chosen: Switches) -> Iterator[ForceVariant]:
    """Laws by absolute angles; by the teeth of another gear, at all meshes or a single one."""
    later = ", ".join(f"theta_{joint + 1}" for joint in layout.mesh_joints if joint)
    if later:
        user_law, reference_law = "the absolute angle", f"the joint's {later}"
        yield ForceVariant(user_law, reference_law, "", arm, chosen, MeshConvention(absolute=True))
    meshes = reference.list_meshes(arm, layout)
    joints: list[Any] = [arm.joints[mesh.joint] for mesh in meshes]  # planetary, as they mesh
    for teeth, field in (("z_s", "sun_teeth"), ("z_p", "planet_teeth")):
        faster = np.array(
            [float(getattr(selected, field) / selected.ring_teeth) for selected in joints]
        )
        yield ForceVariant(teeth, "z_r", "", arm, chosen, MeshConvention(rate_factor=faster))
        for joint, pair in {(m.joint, m.pair): None for m in meshes}:
            selected = np.array([(m.joint, m.pair) == (joint, pair) for m in meshes])
            convention = MeshConvention(rate_factor=np.where(selected, faster, 1.0))
            yield ForceVariant(teeth, "z_r", f"{pair}{joint + 1}", arm, chosen, convention)


def _change_meshes(
    arm: Arm, where: Sequence[tuple[int, str]], field: str, change: Callable[[Any], Any]
) -> Arm:
    """The arm with a field of these meshes changed, for all planets or each planet's."""
    joints = list(arm.joints)
    for place, pair in where:
        mesh: Mesh = getattr(joints[place], SIDES[pair])
        value = getattr(mesh, field)
        other = tuple(map(change, value)) if isinstance(value, tuple) else change(value)
        changed = mesh.model_copy(update={field: other})
        joints[place] = joints[place].model_copy(update={SIDES[pair]: changed})
    return arm.model_copy(update={"joints": tuple(joints)})


class ForceDifferences:
    """The force's entries of one arm, to be explained by differences at the same states.

    states: in the layout's coordinates; rates (K, n): the user's.
    """

    def __init__(
        self,
        frame: Frame,
        arm: Arm,
        chosen: Switches,
        states: ForceStates,
        rates: np.ndarray,
        level: str = "",
    ) -> None:
        self.frame, self.arm, self.switches, self.states = frame, arm, chosen, states
        self.terms = reference.build_reference_terms(frame, arm, chosen, level)
        self.values = collect_arm_values(arm)
        self.angles = states.q[:, frame.layout.theta]
        self.rates = {reference.rate_name(name): rates[:, k] for k, name in enumerate(frame.names)}
        self.signals = self._signals(arm, chosen, USUAL)
        self.harmonic_basis = HarmonicBasis.from_forces(self.terms, self.angles, self.signals)

    def _signals(
        self, arm: Arm, chosen: Switches, convention: MeshConvention
    ) -> dict[str, np.ndarray]:
        columns = reference.compute_signal_columns(
            arm, self.frame.layout, chosen, self.states, convention
        )
        return {**columns, **self.rates}

    def fit_difference(self, difference: np.ndarray, scale: float) -> HarmonicFit:
        """A force's difference (K,), yours minus right, taken apart; scale: the force's size."""
        return self.harmonic_basis.fit(difference, scale, self.values)

    def explain(
        self,
        place: EntryPlace,
        difference: np.ndarray,
        scale: float,
        more: Sequence[HarmonicFit] = (),
    ) -> Explanation | None:
        """Errors in the entry's terms, or another law of the mesh, beside such errors if need be.

        more: the same entry on other arms.
        """
        observed = self.fit_difference(difference, scale)
        explanation = explain(place, [observed, *more], self.terms)
        if explanation or observed.left_over <= UNEXPLAINED:
            return explanation
        return self._explain_by_law(place, difference, scale)

    @cached_property
    def _laws(self) -> list[tuple[ForceVariant, ReferenceTerms, dict[str, np.ndarray]]]:
        laws = []
        for other in generate_force_variants(self.arm, self.frame.layout, self.switches):
            same = other.switches == self.switches
            terms = (
                self.terms
                if same
                else reference.build_reference_terms(self.frame, other.arm, other.switches)
            )
            laws.append((other, terms, self._signals(other.arm, other.switches, other.convention)))
        return laws

    def _explain_by_law(
        self, place: EntryPlace, difference: np.ndarray, scale: float
    ) -> Explanation | None:
        """An explanation by the law, or the two laws, that leave nothing but errors of terms."""
        right = evaluate_entry(self.terms.entry(place), self.values, self.angles, self.signals)
        changes = [
            evaluate_entry(terms.entry(place), self.values, self.angles, signals) - right
            for _, terms, signals in self._laws
        ]
        moved = [number for number, change in enumerate(changes) if np.abs(change).any()]
        size = float(np.linalg.norm(difference))

        def remainder(laws: Sequence[int]) -> np.ndarray:
            return difference - sum(changes[number] for number in laws)

        def select_choices(candidates: Iterable[tuple[int, ...]]) -> list[tuple[int, ...]]:
            """Choices of laws that leave only waves and signals; first those that leave nothing."""
            ranked_choices = []
            for laws in candidates:
                rest = remainder(laws)
                fit = self.harmonic_basis.fit(rest, scale, self.values)
                if fit.left_over * float(np.linalg.norm(rest)) <= UNEXPLAINED * size:
                    ranked_choices.append((len(fit.significant_coefficients), len(laws), laws))
            return [laws for _, _, laws in sorted(ranked_choices)]

        fits = select_choices((number,) for number in moved)
        fits = fits or select_choices(self._find_pairs(moved, changes, difference))
        if not fits:
            return None
        explanations = []
        for laws in fits[:MOST_EXPLANATIONS]:
            errors = tuple(self._laws[number][0].error for number in laws)
            left = float(np.linalg.norm(remainder(laws))) / size
            observed = self.fit_difference(remainder(laws), scale)
            beside = explain(place, [observed], self.terms)
            if beside is not None:
                errors = (*errors, *beside.errors)
                left *= max(beside.left_over, observed.left_over)
            explanations.append((errors, left))
        (errors, left_over), *others = explanations
        return Explanation(errors, left_over, tuple(other for other, _ in others))

    def _find_pairs(
        self, moved: Sequence[int], changes: Sequence[np.ndarray], difference: np.ndarray
    ) -> list[tuple[int, ...]]:
        """Pairs of laws that may leave little, by those parts that no wave or signal makes."""
        rest = self.harmonic_basis.residual(difference)
        parts = np.array([self.harmonic_basis.residual(changes[number]) for number in moved])
        if len(parts) < 2:
            return []
        single = ((parts - rest) ** 2).sum(axis=1) - rest @ rest
        total = rest @ rest + single[:, None] + single[None, :] + 2 * parts @ parts.T
        close = np.argwhere(np.triu(total <= NEARLY * (rest @ rest), 1))
        return [(moved[a], moved[b]) for a, b in close.tolist()]
