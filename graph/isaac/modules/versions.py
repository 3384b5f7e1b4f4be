"""`isaacsim.core.version`."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["Version", "get_version", "parse_version"]


@dataclass
class Version:
    """Parts of "6.0.1-beta.2+main.hash": core, its three numbers, tag and number of a pre-release, build."""

    core: str = ""
    prerelease: str = ""
    major: str = ""
    minor: str = ""
    patch: str = ""
    pretag: str = ""
    prebuild: str = ""
    buildtag: str = ""


def parse_version(full_version: str) -> Version:
    found = re.fullmatch(r"([^-+]*)-?([^+]*)\+?(.*)", full_version.strip(), re.DOTALL)
    core, prerelease, build = found.groups() if found else (full_version, "", "")
    major, minor, patch = (*core.split("."), "", "", "")[:3]
    tag, _, number = prerelease.partition(".")
    return Version(core, prerelease, major, minor, patch, tag, number, build)


def get_version() -> tuple[str, str, str, str, str, str, str, str]:
    one = parse_version("6.0.1")
    return one.core, one.prerelease, one.major, one.minor, one.patch, one.pretag, one.prebuild, one.buildtag
