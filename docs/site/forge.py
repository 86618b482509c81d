"""From Markdown as a forge reads it to what the site's builder reads."""

from __future__ import annotations

import posixpath
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_FENCE = re.compile(r"^(```+|~~~+)", re.MULTILINE)
_HEADING = re.compile(r"^(#{1,6}) +(.+?) *$")
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|`[^`]*`)*)\]\(([^()\s]+)\)")
_FILE = re.compile(r"[\w/]+\.md")
_SOURCE = re.compile(r'\b(src|srcset|href)="([^"]+)"')
_PICTURE = re.compile(
    r'<picture>\s*<source [^>]*srcset="([^"]+)">\s*'
    r'<img\s+src="([^"]+)"\s+alt="([^"]*)">\s*</picture>'
)
_CODE = re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.DOTALL)
_MATHS = re.compile(r"\$\$(.+?)\$\$|(?<![\w$])\$(?!\s)([^$]+?)(?<!\s)\$(?!\w)", re.DOTALL)


def is_external(target: str) -> bool:
    """Whether a link leads out of the checkout."""
    return bool(re.match(r"[a-z]+:|//", target))


def slug(heading: str) -> str:
    """Give the anchor that forges give to a heading."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("*", "")
    kept = re.sub(r"[^\w\- ]", "", plain.strip().lower())
    return kept.replace(" ", "-")


def parts(text: str) -> list[tuple[bool, str]]:
    """Pieces of a text, each with whether it is code: fenced, or indented after a blank line."""
    found: list[tuple[bool, str]] = []
    fence = ""
    blank = True
    for line in text.splitlines(keepends=True):
        opens = _FENCE.match(line)
        if fence:
            code = True
            if line.rstrip() == fence:
                fence = ""
        elif opens:
            code, fence = True, opens[1]
        else:
            indented = line.startswith("    ") and bool(line.strip())
            code = indented and (blank or bool(found and found[-1][0]))
            blank = not line.strip()
        if found and found[-1][0] == code:
            found[-1] = (code, found[-1][1] + line)
        else:
            found.append((code, line))
    return found


def anchors(text: str) -> set[str]:
    """Give the anchors of a page's headings; a repeated one is numbered."""
    found: set[str] = set()
    for code, part in parts(text):
        for line in [] if code else part.splitlines():
            heading = _HEADING.match(line)
            if heading:
                found.add(_fresh(slug(heading[2]), found))
    return found


def links(text: str) -> list[str]:
    """List what a page links to, figures included."""
    prose = "".join(_CODE.sub("", part) for code, part in parts(text) if not code)
    found = [link[3] for link in _LINK.finditer(prose)]
    return found + [link[2] for link in _SOURCE.finditer(prose)]


def _fresh(anchor: str, taken: set[str]) -> str:
    number, given = 0, anchor
    while given in taken:
        number += 1
        given = f"{anchor}-{number}"
    return given


def _maths(found: re.Match[str]) -> str:
    from latex2mathml.converter import convert

    block = found[1] is not None
    tex = " ".join((found[1] or found[2]).split())
    maths = convert(tex, display="block" if block else "inline")
    for sign in "*_\\`|":  # they would be read as Markdown
        maths = maths.replace(sign, f"&#{ord(sign)};")
    return f"\n\n{maths}\n\n" if block else f'<span class="maths">{maths}</span>'


def _figure(found: re.Match[str]) -> str:
    """Give a picture as two, of which the page shows that of its colours; each opens at full size.

    A browser would choose by the setting of the system, which the page's switch does not change.
    """
    dark, light, said = found[1], found[2], " ".join(found[3].split())
    return "".join(
        f'<a class="figure {kind}" href="{file}" title="Open at full size">'
        f'<img src="{file}" alt="{said}" loading="lazy"></a>'
        for kind, file in (("light", light), ("dark", dark))
    )


def staged(
    text: str, source: str, moved: Callable[[str], str | None], titles: Mapping[str, str]
) -> str:
    """Prepare a page: its links lead to where pages are now, its formulas are MathML.

    `moved` gives the place on the site of a file of the checkout; None where it is not there, which
    leaves the words of the link. A link whose words are the name of a file shows the page's title.
    """

    def target(link: str) -> str | None:
        if is_external(link) or link.startswith("#"):
            return link
        file, hash_, anchor = link.partition("#")
        place = moved(posixpath.normpath(posixpath.join(posixpath.dirname(source), file)))
        return None if place is None else place + hash_ + anchor

    def relinked(found: re.Match[str]) -> str:
        place = target(found[3])
        page = (place or "").partition("#")[0]
        words = titles.get(page, found[2]) if _FILE.fullmatch(found[2]) else found[2]
        return words if place is None else f"{found[1]}[{words}]({place})"

    def resourced(found: re.Match[str]) -> str:
        return f'{found[1]}="{target(found[2]) or found[2]}"'

    def prose(part: str) -> str:
        kept: list[str] = []

        def keep(found: re.Match[str]) -> str:
            kept.append(found[0])
            return f"\0{len(kept) - 1}\0"

        part = _MATHS.sub(_maths, _CODE.sub(keep, part))
        # Code within the words of a link stays: links are sought where it is away.
        part = _PICTURE.sub(_figure, _SOURCE.sub(resourced, _LINK.sub(relinked, part)))
        return re.sub("\0(\\d+)\0", lambda found: kept[int(found[1])], part)

    return "".join(part if code else prose(part) for code, part in parts(text))
