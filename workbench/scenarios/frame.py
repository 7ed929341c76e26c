"""The frame: nodes, members, joints and dead loads that fit together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import hypot
from typing import Any, cast

from workbench.errors import InputError
from workbench.fields import Declared, Flag, Instance, Many, checked, did_you_mean
from workbench.materials import Steel
from workbench.scenarios.frame_parts import PREDEFINED, RIGID, Joint, Load, Member, Node
from workbench.scenarios.members import (
    LENGTH,
    MemberProperties,
    member_properties,
    strength_section,
)
from workbench.scenarios.topology import check_connected, check_places, check_supported, extent
from workbench.sections import Section

GRAVITY = 9.81  # m/s2
ROUNDING = 1.0 - 1e-9  # a length that is computed from coordinates


@dataclass(frozen=True)
class Frame(Declared, table="frame"):
    """A planar steel frame.

    Arguments: `nodes`, `members`; `loads`, dead loads that are brought on first and kept;
    `joints` beside the predefined ``rigid`` and ``pinned``; `steel`; `fillets`, whether root
    fillets count in the strength of the sections (stiffness and mass are those of the rolled
    profile either way). Raises `InputError` for names that do not fit together, members without
    length, parts that are not connected, and supports that leave the whole free to move.
    """

    nodes: tuple[Node, ...] = checked(Many(Instance(Node), 2))
    members: tuple[Member, ...] = checked(Many(Instance(Member), 1))
    loads: tuple[Load, ...] = checked(Many(Instance(Load)), ())
    joints: tuple[Joint, ...] = checked(Many(Instance(Joint)), ())
    steel: Steel = checked(Instance(Steel), Steel())
    fillets: bool = checked(Flag(), True)

    def check(self) -> None:
        """Refuse parts that do not fit together, do not hang together or are not held."""
        for joint in self.joints:
            if joint.name in PREDEFINED:
                raise InputError("joint.name", joint.name, "is predefined", "choose another name")
        for parts in self._lists.values():
            counts = Counter(part.name for part in parts)
            for part in parts:
                if counts[part.name] > 1:
                    raise part.refusal("name", "is given twice", "names must be unique")
        for member in self.members:
            self._check_member(member)
        for load in self.loads:
            self.node(load.node, f"load.{load.node}.node")
        check_places(self.nodes, self.members)
        check_connected(self.nodes, self.members)
        check_supported(self.nodes, self.turned, loaded=bool(self.loads))

    def _check_member(self, member: Member) -> None:
        path = f"member.{member.name}"
        for end in ("start", "end"):
            self.node(getattr(member, end), f"{path}.{end}")
            self.joint(getattr(member, f"joint_{end}"), f"{path}.joint_{end}")
        length = self.length(member)
        if not LENGTH.low * ROUNDING <= length <= LENGTH.high / ROUNDING:
            ends = f"between {member.start} and {member.end}"
            text = f"is {length:g} m long {ends}; a length {LENGTH.allowed()}"
            raise member.refusal("", text, LENGTH.advice)

    @cached_property
    def turned(self) -> set[str]:
        """Names of nodes that cannot turn without a member."""
        ends = [(m.start, m.joint_start) for m in self.members]
        ends += [(m.end, m.joint_end) for m in self.members]
        return {node for node, joint in ends if self.joint(joint).rotational_stiffness != 0.0}

    @property
    def _lists(self) -> dict[str, Sequence[Any]]:
        return {"node": self.nodes, "member": self.members, "joint": self.joints}

    @cached_property
    def _parts(self) -> dict[str, dict[str, Any]]:
        """Nodes, members and joints by their kind and name."""
        named = {kind: {part.name: part for part in parts} for kind, parts in self._lists.items()}
        return {**named, "joint": PREDEFINED | named["joint"]}

    @cached_property
    def _properties(self) -> dict[str, MemberProperties]:
        return {
            member.name: member_properties(member, self.steel, self.length(member), self.fillets)
            for member in self.members
        }

    def node(self, name: str, path: str = "node") -> Node:
        """The node of this name. Raises `InputError` naming `path`."""
        return cast(Node, _named("node", self._parts["node"], name, path))

    def member(self, name: str, path: str = "member") -> Member:
        """The member of this name. Raises `InputError` naming `path`."""
        return cast(Member, _named("member", self._parts["member"], name, path))

    def joint(self, name: str, path: str = "joint") -> Joint:
        """The joint of this name. Raises `InputError` naming `path`."""
        return cast(Joint, _named("joint", self._parts["joint"], name, path))

    @cached_property
    def extent(self) -> float:
        """Diagonal of the box around the nodes, in m."""
        return extent(self.nodes)

    @cached_property
    def load_masses(self) -> dict[str, float]:
        """Masses (kg) that weigh what the dead loads on the nodes of these names do."""
        weights: Counter[str] = Counter()
        for load in self.loads:
            weights[load.node] += -load.y  # type: ignore[assignment]
        return {name: weight / GRAVITY for name, weight in weights.items() if weight > 0.0}

    def length(self, member: Member | str) -> float:
        """Length of a member, in m."""
        given = self._own(member)
        start, end = self.node(given.start), self.node(given.end)
        return hypot(end.x - start.x, end.y - start.y)

    def properties(self, member: Member | str) -> MemberProperties:
        """Section values of a member with its overrides applied."""
        return self._properties[self._own(member).name]

    def strength_section(self, member: Member | str) -> Section:
        """The section whose fibers and envelope give a member's strength (`fillets` applied)."""
        return strength_section(self._own(member).section, self.fillets)

    def split(self, member: Member | str, at: float, node: str) -> Frame:
        """The frame with a new `node` on a member, `at` m from its start.

        The parts are named ``<member>/1`` and ``<member>/2``; joints stay at the outer ends.
        Raises `InputError`.
        """
        name = member.name if isinstance(member, Member) else member
        return self.split_all([(name, at, node)])

    def split_all(self, splits: Iterable[tuple[str, float, str]]) -> Frame:
        """The frame after many splits, each as in `split`, which is checked once as a whole."""
        nodes, members = dict(self._parts["node"]), list(self.members)
        for name, at, node in splits:
            known = {member.name: member for member in members}
            whole = _named("member", known, name, "split.member")
            start, end = nodes[whole.start], nodes[whole.end]
            length = hypot(end.x - start.x, end.y - start.y)
            distance = float(LENGTH.check("split.at", at))
            if not distance <= length - LENGTH.low:
                on = (
                    f"must lie on member {name}, from {LENGTH.low:g} to {length - LENGTH.low:.6g} m"
                )
                advice = "measure from the start of the member"
                raise InputError("split.at", at, f"{on} from its start", advice)
            if node in nodes:
                text = "is the name of a node already"
                raise InputError("split.node", node, text, "choose another")
            share = distance / length
            x, y = start.x + share * (end.x - start.x), start.y + share * (end.y - start.y)
            nodes[node] = Node(node, x, y)
            place = members.index(whole)
            members[place : place + 1] = (
                replace(whole, name=f"{name}/1", end=node, joint_end=RIGID.name),
                replace(whole, name=f"{name}/2", start=node, joint_start=RIGID.name),
            )
        return replace(self, nodes=tuple(nodes.values()), members=tuple(members))

    def _own(self, member: Member | str) -> Member:
        return self.member(member.name if isinstance(member, Member) else member)


def _named(kind: str, parts: Mapping[str, Any], name: str, path: str) -> Any:
    """The part of this name. Raises `InputError` naming `path`, with the nearest names."""
    if isinstance(name, str) and name in parts:
        return parts[name]
    shown = ", ".join(list(parts)[:8]) + (", ..." if len(parts) > 8 else "")
    advice = did_you_mean(name, parts, f"known are {shown}")
    raise InputError(path, name, f"there is no {kind} of this name", advice)
