"""Workflows, forms and the citation say what the rest of the tree says."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.helpers import ROOT, looped
from tests.meta.test_tree import _version

yaml = pytest.importorskip("yaml", reason='the group "site", which reads YAML, is not installed')

FORGE = ROOT / ".github"
WORKFLOWS = sorted((FORGE / "workflows").glob("*.yml"))
NAMES = [file.stem for file in WORKFLOWS]
_PINNED = re.compile(r"^ *(?:- )?uses: [\w./-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+$")
# What a job may do beside reading, and where it publishes.
_MORE = {
    ("wheels", "publish"): {"id-token": "write"},
    ("site", "publish"): {"pages": "write", "id-token": "write"},
}


def _read(name: str) -> dict[Any, Any]:
    text = (FORGE / "workflows" / f"{name}.yml").read_text(encoding="utf-8")
    found: dict[Any, Any] = yaml.safe_load(text)
    return found


def _pyproject() -> str:
    return (ROOT / "pyproject.toml").read_text(encoding="utf-8")


def _supported() -> list[str]:
    return re.findall(r'"Programming Language :: Python :: (3\.\d+)"', _pyproject())


def test_there_are_workflows_for_tests_wheels_and_site() -> None:
    assert NAMES == ["ci", "site", "wheels"]


@looped("name", NAMES)
def test_actions_are_pinned_to_commits(name: str) -> None:
    lines = (FORGE / "workflows" / f"{name}.yml").read_text(encoding="utf-8").splitlines()
    used = [line for line in lines if "uses:" in line]
    assert used
    assert [line for line in used if not _PINNED.match(line)] == []


def test_one_action_has_one_version() -> None:
    used = {
        found
        for file in WORKFLOWS
        for found in re.findall(r"uses: (.+)@(\w+)", file.read_text(encoding="utf-8"))
    }
    assert len({action for action, _ in used}) == len(used)


@looped("name", NAMES)
def test_jobs_may_read_and_no_more_but_where_they_publish(name: str) -> None:
    workflow = _read(name)
    assert workflow["permissions"] == {"contents": "read"}
    for job, what in workflow["jobs"].items():
        assert what.get("permissions", {}) == _MORE.get((name, job), {}), job
        assert what["timeout-minutes"] <= 90, job


@looped("name", NAMES)
def test_commands_of_workflows_exist(name: str) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    jobs = _read(name)["jobs"]
    for job, what in jobs.items():
        needs = what.get("needs", [])
        assert set([needs] if isinstance(needs, str) else needs) <= set(jobs), job
        for step in what["steps"]:
            run = str(step.get("run", ""))
            outside = run.replace("${{ matrix.", "")
            assert "${{" not in outside, f"{job}: what an event says must not become code: {run}"
            for target in re.findall(r"\bmake ([\w-]+)", run):
                assert f"\n{target}:" in makefile, target
            for path in re.findall(r"\btests/[\w/.]+", run):
                assert (ROOT / path).exists(), path
            if "working-directory" in step and "${{" not in step["working-directory"]:
                assert (ROOT / step["working-directory"]).is_dir()


def test_workflows_run_the_pythons_that_are_supported() -> None:
    supported = _supported()
    assert f'requires-python = ">={supported[0]}"' in _pyproject()
    ci, wheels = _read("ci")["jobs"], _read("wheels")["jobs"]
    assert ci["python"]["strategy"]["matrix"]["python"] == supported
    assert ci["windows"]["strategy"]["matrix"]["python"] == supported
    # One wheel for all of them by the stable ABI of the oldest; free-threaded ones have none.
    binding = (ROOT / "rust" / "py" / "Cargo.toml").read_text(encoding="utf-8")
    assert f'"abi3-py{supported[0].replace(".", "")}"' in binding
    (args,) = (
        step["with"]["args"] for step in wheels["linux"]["steps"] if "args" in step.get("with", {})
    )
    for built in (
        wheels["others"]["strategy"]["matrix"]["python"],
        args.partition("-i ")[2].split(),
    ):
        stable, *others = built
        assert stable in supported
        assert others
        _check_free_threaded(others)
    _check_free_threaded(ci["free-threaded"]["strategy"]["matrix"]["python"])


def _check_free_threaded(pythons: list[str]) -> None:
    """Hold that they are free-threaded ones that PyO3 builds for: it refuses 3.13t."""
    for each in pythons:
        assert each.endswith("t"), each
        assert int(each.removeprefix("3.").removesuffix("t")) >= 14, each


def test_workflows_build_by_the_oldest_rust_that_is_named() -> None:
    manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
    (oldest,) = re.findall(r'^rust-version = "(.+)"$', manifest, re.MULTILINE)
    commands = [str(step.get("run")) for step in _read("ci")["jobs"]["msrv"]["steps"]]
    assert sum(oldest in command for command in commands) == 2


def test_citation_has_the_version_and_the_paper_of_the_page() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == _version()
    (paper,) = citation["references"]
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    assert paper["title"] in " ".join(page.split())
    assert paper["doi"] in page


@looped("form", ["bug", "tracking", "wish"])
def test_issue_form_has_what_a_forge_asks_for(form: str) -> None:
    text = (FORGE / "ISSUE_TEMPLATE" / f"{form}.yml").read_text(encoding="utf-8")
    found = yaml.safe_load(text)
    assert {"name", "description", "body"} <= set(found)
    fields = [each for each in found["body"] if each["type"] != "markdown"]
    assert all(each["type"] in ("textarea", "input", "dropdown") for each in fields)
    assert all(each["attributes"]["label"] for each in fields)
    assert len({each["id"] for each in fields}) == len(fields)
    assert any(each.get("validations", {}).get("required") for each in fields)
