"""Frames in files: nodes and members, or axes and levels; splits refine both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, count, islice, pairwise, product
from string import ascii_uppercase

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Flag, Instance, Many, checked
from workbench.scenarios.frame import Frame
from workbench.scenarios.parts import LENGTH, NAME, RIGID, Joint, Load, Member, Node
from workbench.steel.materials import Steel
from workbench.steel.sections import SECTION, Section

SPANS = Many(LENGTH, 1, 100)


@dataclass(frozen=True)
class RegularForm(Declared, table="frame"):
    """A frame of columns on axes A, B, ... and of beams on every level; see `regular_frame`."""

    bays: tuple[float, ...] = checked(SPANS)
    storeys: tuple[float, ...] = checked(SPANS)
    column: Section = checked(SECTION)
    beam: Section = checked(SECTION)
    base: str = checked(Choice(("clamped", "pinned")), "clamped")
    beam_joint: str = checked(NAME, RIGID.name)

    def frame(self, steel: Steel, fillets: bool, joints: Sequence[Joint]) -> Frame:
        """Return the frame, its beams joined by one of `joints`. Raises `InputError`."""
        words = (product(ascii_uppercase, repeat=length) for length in count(1))
        letters = ("".join(word) for word in chain.from_iterable(words))
        axes = list(islice(letters, len(self.bays) + 1))  # A to Z, then AA, AB and so on
        levels = range(len(self.storeys) + 1)
        nodes = []
        for level, i in product(levels, range(len(axes))):
            x, y = sum(self.bays[:i]), sum(self.storeys[:level])
            nodes.append(Node(f"{axes[i]}{level}", x, y, "free" if level else self.base))
        columns = [(f"{axis}{i}", f"{axis}{i + 1}") for axis in axes for i in levels[:-1]]
        beams = [(f"{a}{i}", f"{b}{i}") for i in levels[1:] for a, b in pairwise(axes)]
        joint = self.beam_joint
        members = [Member(f"{a}-{b}", a, b, self.column) for a, b in columns]
        members += [Member(f"{a}-{b}", a, b, self.beam, joint, joint) for a, b in beams]
        return Frame(tuple(nodes), tuple(members), (), tuple(joints), steel, fillets)


@dataclass(frozen=True)
class Split(Declared, table="split"):
    """A new `node` on a `member`, `at` m from its start."""

    member: str = checked(NAME)
    at: float = checked(LENGTH)
    node: str = checked(NAME)


@dataclass(frozen=True)
class FrameForm(Declared):
    """A frame as files show it; written with nodes and members, read in both forms."""

    fillets: bool = checked(Flag(), True, path="frame.fillets")
    steel: Steel = checked(Instance(Steel), Steel())
    regular: RegularForm | None = checked(
        Instance(RegularForm, instead_of=("node", "member")), optional=True
    )
    nodes: tuple[Node, ...] = checked(Many(Instance(Node)), (), path="node")
    joints: tuple[Joint, ...] = checked(Many(Instance(Joint)), (), path="joint")
    members: tuple[Member, ...] = checked(Many(Instance(Member)), (), path="member")
    splits: tuple[Split, ...] = checked(Many(Instance(Split)), (), path="split")
    loads: tuple[Load, ...] = checked(Many(Instance(Load)), (), path="load")

    @classmethod
    def of(cls, frame: Frame) -> FrameForm:
        """Return the form of a frame that lists its parts."""
        parts = frame.nodes, frame.joints, frame.members
        return cls(frame.fillets, frame.steel, None, *parts, loads=frame.loads)

    def build(self) -> Frame:
        """Return the frame. Raises `InputError`."""
        if self.regular is not None:
            for joint in self.joints:
                if joint.name != self.regular.beam_joint:
                    path, text = f"joint.{joint.name}", "is no joint of this regular frame"
                    advice = "name it as frame.beam_joint, or list nodes and members"
                    raise InputError(path, None, text, advice)
            frame = self.regular.frame(self.steel, self.fillets, self.joints)
        else:
            for name, parts in (("node", self.nodes), ("member", self.members)):
                if not parts:
                    advice = f"add [[{name}]], or bays and storeys in [frame]"
                    raise InputError(name, None, f"the tables [[{name}]] are missing", advice)
            frame = Frame(self.nodes, self.members, (), self.joints, self.steel, self.fillets)
        if self.splits:
            frame = frame.split_all((split.member, split.at, split.node) for split in self.splits)
        return replace(frame, loads=self.loads) if self.loads else frame


def regular_frame(
    bays: Sequence[float],
    storeys: Sequence[float],
    column: Section,
    beam: Section,
    base: str = "clamped",
    steel: Steel | None = None,
    fillets: bool = True,
    beam_joint: str | Joint = RIGID.name,
    joints: Sequence[Joint] = (),
) -> Frame:
    """Return a frame of columns on axes A, B, ... and of beams on every level above the ground.

    Arguments: widths of the `bays` from the left and heights of the `storeys` from the ground, in
    m; sections; `base`, clamped or pinned; `beam_joint` at both ends of every beam, a joint or the
    name of one of `joints`, rigid or pinned. Nodes are named A0, B0, ..., A1, ... (axis and level),
    columns A0-A1 (from the bottom to the top), beams A1-B1 (from the left to the right).
    Raises `InputError`.
    """
    if isinstance(beam_joint, Joint):
        joints, beam_joint = (*joints, beam_joint), beam_joint.name
    form = RegularForm(tuple(bays), tuple(storeys), column, beam, base, beam_joint)
    return form.frame(Steel() if steel is None else steel, fillets, joints)
