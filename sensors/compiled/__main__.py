"""python -m sensors.compiled: compiles every listed loop, and puts the code into the package, for a wheel to carry."""

from __future__ import annotations

import shutil

from .kept import SHIPPED, user_folder
from .signatures import listed
from .warming import warm


def fill() -> int:
    """Fills `kept.SHIPPED`; returns the number of files."""
    for _ in warm():
        pass
    SHIPPED.mkdir(exist_ok=True)
    places = [loop.kept.places(types, loop.code.targetctx.codegen()) for loop, types in listed()]
    names = {files[0].name for files in places}
    for old in SHIPPED.iterdir():
        if old.name not in names:
            old.unlink()
    for name in names:
        if not (SHIPPED / name).exists():
            shutil.copyfile(user_folder() / name, SHIPPED / name)
    return len(names)


if __name__ == "__main__":
    print(f"{fill()} compiled loops in {SHIPPED}")
