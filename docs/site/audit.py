"""Checks the dependencies: known vulnerabilities, licences, sources. `make audit` runs it.

Both databases of known vulnerabilities are on the network. If one cannot be reached, its check is
reported as not made, and the exit status is 0 if nothing else was found; with `--online` a check
that was not made is an error, as in continuous integration.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DENY = ("cargo", "deny", "--locked")
CONFIG = ("--config", "rust/deny.toml", "check")
PASSED, FAILED, NOT_MADE = "passed", "FAILED", "not made"


def _run(*command: str) -> tuple[int, str]:
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def crates() -> tuple[str, str]:
    """Check licences, sources and versions of the crates; needs no network once they are there."""
    status, said = _run(*DENY, "--offline", *CONFIG, "bans", "licenses", "sources")
    return (PASSED, said.strip().splitlines()[-1]) if status == 0 else (FAILED, said)


def crates_known_holes() -> tuple[str, str]:
    """Check the crates against RustSec's data base."""
    status, said = _run(*DENY, *CONFIG, "advisories")
    if status == 0:
        return PASSED, said.strip().splitlines()[-1]
    if "failed to fetch advisory database" in said:
        return NOT_MADE, "RustSec's data base cannot be reached"
    return FAILED, said


def packages_known_holes() -> tuple[str, str]:
    """Check the installed Python packages against the data base of PyPI."""
    options = ("--format", "json", "--progress-spinner", "off", "--local")
    status, said = _run(sys.executable, "-m", "pip_audit", *options)
    begin = said.find('{"dependencies"')
    if begin < 0:
        return NOT_MADE, said.strip()
    found = json.JSONDecoder().raw_decode(said[begin:])[0]["dependencies"]
    checked = [each for each in found if "vulns" in each]
    holes = [f"{each['name']} {each['version']}" for each in checked if each["vulns"]]
    if holes or (status != 0 and checked):
        return FAILED, ", ".join(holes) or said
    if not checked:
        return NOT_MADE, "the service knows none of the packages: not PyPI itself?"
    return PASSED, f"{len(checked)} of {len(found)} packages are known to it, none vulnerable"


CHECKS = {
    "crates: licences, sources, versions": crates,
    "crates: known vulnerabilities": crates_known_holes,
    "packages: known vulnerabilities": packages_known_holes,
}


def main() -> None:
    """Make all checks, and say of each how it ended."""
    parser = argparse.ArgumentParser(description="Check the dependencies.")
    parser.add_argument("--online", action="store_true", help="a check not made is an error")
    refused = {FAILED, NOT_MADE} if parser.parse_args().online else {FAILED}
    if shutil.which("cargo-deny") is None:
        sys.exit("cargo-deny is missing: cargo install cargo-deny --locked")
    ended = set()
    for name, check in CHECKS.items():
        result, said = check()
        ended.add(result)
        print(f"{result:8}  {name}: {said}", flush=True)
    sys.exit(1 if ended & refused else 0)


if __name__ == "__main__":
    main()
