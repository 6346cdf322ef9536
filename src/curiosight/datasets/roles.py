"""What the names of image files say of them: colour, depth, confidence, or something else."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from curiosight.datasets.depth_files import ARRAY_ENDINGS, DEPTH_ENDINGS
from curiosight.datasets.listing import IMAGE_ENDINGS, natural_key


class Role(Enum):
    """What an image file is for."""

    COLOUR = "colour"
    DEPTH = "depth"
    CONFIDENCE = "confidence"
    OTHER = "something else"
    UNSAID = "unsaid"


WORDS = {
    Role.COLOUR: "color colour colors colours rgb rgbs image images img imgs bgr",
    Role.DEPTH: "depth depths depthmap depthmaps depthimage",
    Role.CONFIDENCE: "conf confidence confidences",
    Role.OTHER: "mask masks seg segs segm segmask segmasks segmentation segmentations label labels "
    "annotation annotations gt groundtruth truth normal normals result results output outputs "
    "pred preds prediction predictions vis viz visual visualization overlay overlays instance "
    "instances semantic semantics panoptic heatmap saliency ir infrared infra preview previews "
    "thumb thumbnail thumbnails debug flow edge edges disparity pose poses colormap error diff",
}
ROLE_OF = {word: role for role, words in WORDS.items() for word in words.split()}
# They may stand in any name, of depth too.
WEAK_WORDS = frozenset(["image", "images", "img", "imgs"])
# Files by what they are called, but for numbers, and by ending.
Groups = dict[tuple[str, str], list[Path]]
ENDINGS = frozenset(IMAGE_ENDINGS) | frozenset(DEPTH_ENDINGS)


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Files of a folder that are called alike but for their numbers.

    role: as the names say, or else the folder's name. has_own: the files' names say it.
    """

    folder: Path
    role: Role
    files: tuple[Path, ...]
    has_own: bool


def words_of(name: str) -> list[str]:
    """Cut a name into small words and numbers.

    >>> words_of("frame-000012.Color")
    ['frame', '000012', 'color']
    """
    return re.findall(r"[a-z]+|\d+", re.sub(r"([a-z])([A-Z])", r"\1 \2", name).lower())


def role_of(name: str) -> Role:
    """Return what a file's or folder's name says; of colour and depth, the first counts.

    >>> role_of("aligned_depth_to_color"), role_of("depth_mask"), role_of("000012")
    (<Role.DEPTH: 'depth'>, <Role.OTHER: 'something else'>, <Role.UNSAID: 'unsaid'>)
    """
    words = [word for word in words_of(name) if word in ROLE_OF]
    roles = [ROLE_OF[word] for word in words if word not in WEAK_WORDS]
    for role in (Role.OTHER, Role.CONFIDENCE):
        if role in roles:
            return role
    return roles[0] if roles else Role.COLOUR if words else Role.UNSAID


def frame_key(stem: str) -> str:
    """Return what is left of a name without the words of roles: what files of a frame share.

    >>> frame_key("color_0007"), frame_key("0007.depth"), frame_key("rgb")
    ('0007', '0007', '')
    """
    key = stem
    for word in ROLE_OF:
        bounded = rf"(?<![A-Za-z]){word}(?![A-Za-z])"
        key = re.sub(rf"(^|[-_. ]){bounded}|{bounded}([-_. ]|$)", "", key, flags=re.IGNORECASE)
    return key.strip("-_. ")


def find_groups(root: Path) -> list[Group]:
    """Return the groups of image files in a folder, and in those of its folders with a role."""
    groups = list(_groups_in(root, Role.UNSAID))
    for child in _folders(root):
        role = role_of(child.name)
        if role in (Role.COLOUR, Role.DEPTH, Role.CONFIDENCE):
            groups += _groups_in(child, role)
    return groups


def _groups_in(folder: Path, role: Role) -> Iterator[Group]:
    alike: Groups = {}
    for path in folder.iterdir():
        ending = path.suffix.lower()
        if ending in ENDINGS and not path.name.startswith("."):
            form = re.sub(r"\d+", "0", path.stem), ending
            alike.setdefault(form, []).append(path)
    alike = _with_named_together(alike)
    for form in sorted(alike):
        files = sorted(alike[form], key=lambda path: natural_key(path.name))
        own = role_of(files[0].stem)
        # An array is no picture: beside colour it is depth where nothing else is said.
        is_array = files[0].suffix.lower() in ARRAY_ENDINGS
        if is_array and own is Role.UNSAID and role is Role.UNSAID:
            own = Role.DEPTH
        is_said = own is not Role.UNSAID
        yield Group(folder, own if is_said else role, tuple(files), is_said)


def _with_named_together(alike: Groups) -> Groups:
    """Put together files that have a word each where others have a number: mug_rgb, cup_rgb."""
    merged: Groups = {}
    for (stem, ending), files in alike.items():
        role = role_of(stem)
        is_named = len(files) == 1 and role in (Role.COLOUR, Role.DEPTH, Role.CONFIDENCE)
        merged.setdefault((f"*{role.value}" if is_named else stem, ending), []).extend(files)
    return merged


def _folders(root: Path) -> list[Path]:
    found = (child for child in root.iterdir() if child.is_dir() and child.name[0] != ".")
    return sorted(found, key=lambda path: natural_key(path.name))
