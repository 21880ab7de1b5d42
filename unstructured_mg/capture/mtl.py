"""OBJ material libraries: which image a material's colour comes from."""

# Options of a texture statement and the most values each takes; the rest of the line is the file's name.
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2,
    "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1,
}  # fmt: skip


def read_mtl(text: str) -> dict[str, str]:
    """Material name to the file name of its ``map_Kd`` (or ``map_Ka`` where it has no ``map_Kd``), as written.

    File names may hold spaces and quotes; options before the name are skipped. Materials without an image are left out.
    """
    diffuse: dict[str, str] = {}
    ambient: dict[str, str] = {}
    material = ""
    for line in text.splitlines():
        keyword, _, rest = line.strip().partition(" ")
        if "\t" in keyword:
            keyword, _, rest = line.strip().partition("\t")
        if keyword == "newmtl":
            material = rest.strip()
        elif keyword.lower() in ("map_kd", "map_ka"):
            name = _file_name(rest)
            if name:
                (diffuse if keyword.lower() == "map_kd" else ambient).setdefault(material, name)
    return ambient | diffuse


def _file_name(arguments: str) -> str:
    rest = arguments.strip()
    while rest.startswith("-"):
        option, _, after = rest.partition(" ")
        most = _OPTIONS.get(option.lower())
        if most is None:
            break
        rest = after.strip()
        for taken in range(most):
            value, _, after = rest.partition(" ")
            # -o, -s and -t take one to three numbers: a word that is none begins the file's name
            if taken > 0 and option.lower() in ("-o", "-s", "-t") and not _is_number(value):
                break
            rest = after.strip()
    if len(rest) > 1 and rest[0] == rest[-1] == '"':
        rest = rest[1:-1]
    return rest


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
