#!/usr/bin/env python3
"""Checks what a compiler can't: which room includes which, that every room is described, that links, citations and the
README's table hold, and that nothing names a place on somebody's machine. Prints every violation and fails if there is one.

    python3 check_tree.py [ROOT]    ROOT: the tree to check; default: this one
"""
import pathlib
import re
import subprocess
import sys

# What each room may include besides itself. Later rooms may include all earlier ones of their line.
LINE = ["base", "mesh", "fem", "compliance", "cut", "contact", "sim", "trainer"]
ALLOWED = {room: set(LINE[:i]) for i, room in enumerate(LINE)}
ALLOWED["image"] = {"base", "mesh"}
ALLOWED["patient"] = {"base", "mesh", "image"}
ALLOWED["scene"] = {"base", "mesh", "fem", "compliance", "cut", "contact", "sim", "image", "patient"}
ALLOWED["device"] = {"base"} | set(LINE[:LINE.index("trainer")])
ALLOWED["picture"] = {"base", "mesh"}
ALLOWED["view"] = ALLOWED["scene"] | {"scene", "picture"}
ALLOWED["sound"] = {"base"}

SOURCES = {".h", ".cpp"}
TEXTS = SOURCES | {".md", ".txt", ".cmake", ".py", ".sh", ".json", ".bib", ".toml", ".in", ""}
# A path that only exists for one person: a home, or a working place at the root.
MACHINE_PATH = re.compile(r"(?<![\w.$}/-])/(?:home|root|Users|work|workspace|mnt|media|scratch)/[\w.-]+")
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]((?:calot|app|bench|tests)/[^">]+)[">]', re.MULTILINE)
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)\]")
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")


def files(root):
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True)
    if listed.returncode == 0 and listed.stdout:
        return [root / name for name in listed.stdout.splitlines() if (root / name).is_file()]
    return [path for path in root.rglob("*") if path.is_file() and path.relative_to(root).parts[0] not in ("build", "out", ".git")]


def check_includes(path, text, folder):
    for match in INCLUDE.finditer(text):
        target = pathlib.PurePosixPath(match[1]).parts
        line = text.count("\n", 0, match.start()) + 1
        if folder[0] == "calot" and target[0] != "calot":
            yield f"{path}:{line}: nothing in calot/ includes {target[0]}/"
        if folder[0] != "calot" or len(folder) < 3 or len(target) < 3:
            continue
        room, other = folder[1], target[1]
        if room not in ALLOWED:
            yield f"{path}:{line}: calot/{room} is not a room that DESIGN knows; add it to LINE or ALLOWED in check_tree.py"
        elif other != room and other not in ALLOWED[room]:
            yield f"{path}:{line}: {room} may not include {other}"
        if room == "sim" and re.search(r"GL|epoxy", match[1]):
            yield f"{path}:{line}: sim may not include OpenGL"


def check_rooms(root):
    page = root / "docs/architecture.md"
    described = page.read_text() if page.exists() else ""
    for room in sorted(path for path in (root / "calot").iterdir() if path.is_dir()):
        if f"`{room.name}/`" not in described:
            yield f"docs/architecture.md: says nothing of calot/{room.name}/"
    for name in re.findall(r"^\| `(\w+)/`", described, re.MULTILINE):
        if not (root / "calot" / name).is_dir():
            yield f"docs/architecture.md: describes calot/{name}/, which isn't there"


def check_links(root, path, text):
    for match in LINK.finditer(text):
        target = match[1]
        if re.match(r"[a-z]+:", target):
            continue
        if not (path.parent / target).exists():
            yield f"{path.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}: links to {target}, which isn't there"


def check_citations(root, texts):
    bibliography = root / "docs/references.bib"
    known = set(re.findall(r"^@\w+\{(\w+),", bibliography.read_text(), re.MULTILINE)) if bibliography.exists() else set()
    for path, text in texts.items():
        for match in CITATION.finditer(text):
            if match[1] not in known:
                line = text.count("\n", 0, match.start()) + 1
                yield f"{path.relative_to(root)}:{line}: cites [{match[1]}], which docs/references.bib doesn't have"


def check(root):
    texts = {}
    for path in files(root):
        name = path.relative_to(root)
        if path.suffix in TEXTS and name.name != "LICENSE":
            try:
                texts[path] = path.read_text()
            except UnicodeDecodeError:
                continue
    for path, text in texts.items():
        name = path.relative_to(root)
        if path.suffix in SOURCES:
            yield from check_includes(name, text, name.parts)
        if path.suffix == ".md":
            yield from check_links(root, path, text)
        for match in MACHINE_PATH.finditer(text):
            yield f"{name}:{text.count(chr(10), 0, match.start()) + 1}: names a place on one machine, {match[0]}"
    yield from check_rooms(root)
    yield from check_citations(root, texts)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[2])
    problems = list(check(root))
    for problem in problems:
        print(problem)
    sys.exit(1 if problems else 0)


main()
