"""Dependencies point one way only: in the package, in the core, and between the two."""

import ast
import graphlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "hypertuna"
HEADERS = ROOT / "core" / "include" / "hypertuna"

# The reading order of the package: each module may import only those before it. The commands use what users use.
LAYERS = (
    *(
        "_core",
        "errors",
        "frames",
        "schema_base",
        "schema_*",
        "schema",
        "reference",
        "description",
        "gait",
        "model",
        "metrics",
        "beats",
    ),
    *("results", "swim", "sweep", "measured", "smoothing", "replay"),
    *(
        "dialect",
        "radio",
        "mcap_file",
        "link_log",
        "steady",
        "link_trials",
        "manifest",
        "importers",
        "trials",
        "comparison",
        "journal",
    ),
    *(
        "free_names",
        "truncated",
        "coefficients",
        "robot_file",
        "predict",
        "agreement",
        "valley",
        "certainty",
        "fit_warnings",
        "search",
        "identify",
        "posterior",
    ),
    "turn",
    *("space", "limits", "objective", "robust", "optimizers", "walk", "descents", "optimum", "optimize", "experiment"),
    *("evolution", "polish", "pareto"),
    *("silicone", "soft_joint", "actuator"),
    *("fe_extra", "fe_geometry", "fe_mesh", "fe_solid", "fe_mixed", "fe_newton", "fe_model", "fe_measure", "fe_bend"),
    *("fe_record", "fe_fields", "fe_points", "fe_potential", "fe_reduced", "fe_section", "fe_compare"),
    *("fe_tube", "fe_blocks", "fe_cases"),
    *("bench", "bench_unknowns", "bench_combinations", "bench_search", "bench_draws", "bench_fit", "bench_worth"),
    *("hydraulics", "sizing", "control", "sensing", "energy", "mission", "guidance"),
    *("twin_run", "twin_parts", "twin", "posture", "sobol", "sea", "sea_run", "sea_twin", "dive", "mission_run"),
    *("geodesy", "schema_mission", "mission_file", "mission_record", "gpx", "log_fields", "mcap_log", "mcap_read"),
    *("flight", "link_client", "link_parameters", "link_mission", "link_calibrate", "drive"),
    *("firmware_params", "black_box", "lockstep", "boards", "relay", "fil_scenario", "fil"),
    *("drawing", "style", "fe_pictures", "plots", "plots_*", "animation", "report", "fit_page", "results_page"),
    *("published_swims", "published_twins", "ledger", "reproduce_*", "reproduce", "ledger_page"),
    *("__init__", "console", "options", "cli_optimize", "cli_bench", "cli_link", "cli_fe_options", "cli_fe_reduce"),
    *("cli_fe_validate", "cli_fe_compare", "cli_*", "cli", "__main__"),
)

# The core runs on a microcontroller: no heap, no exceptions, no input or output, nothing of Python.
STANDARD_HEADERS = {
    *("algorithm", "array", "bit", "cmath", "concepts", "cstddef", "cstdint", "initializer_list", "limits"),
    *("type_traits", "utility"),
}


def layer(module: str) -> int:
    """Place of a module in the reading order."""
    families = (f"{family}_*" for family in ("cli", "plots", "reproduce", "schema") if module.startswith(f"{family}_"))
    name = module if module in LAYERS else next(families, module)
    assert name in LAYERS, f"src/hypertuna/{module}.py has no place in the reading order of tests/test_layers.py yet"
    return LAYERS.index(name)


def imported_modules(source: Path) -> set[str]:
    """Modules of the package that a module imports, whichever way it spells it and wherever in the file."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(filter(None, ["hypertuna" if node.level else "", node.module]))
            names |= {f"{base}.{alias.name}" for alias in node.names}
    inside = {f"{name}.".split(".")[1] for name in names if name.split(".")[0] == "hypertuna"}
    return {name if name == "_core" or (PACKAGE / f"{name}.py").exists() else "__init__" for name in inside}


@pytest.mark.parametrize("source", sorted(PACKAGE.glob("*.py")), ids=lambda path: path.stem)
def test_module_imports_only_earlier_modules(source: Path) -> None:
    later = {name for name in imported_modules(source) if layer(name) >= layer(source.stem)}
    assert not later, f"{source.stem} must not import {sorted(later)}: they come later in the reading order"


def includes(source: Path) -> list[tuple[str, str]]:
    """Pairs of delimiter and header that a C++ file includes."""
    return re.findall(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', source.read_text(), flags=re.MULTILINE)


def test_headers_of_the_core_include_each_other_one_way() -> None:
    graph = {
        f"hypertuna/{path.relative_to(HEADERS)}": {name for mark, name in includes(path) if mark == '"'}
        for path in HEADERS.rglob("*.hpp")
    }
    order = list(graphlib.TopologicalSorter(graph).static_order())  # raises CycleError naming the cycle
    assert set(order) == set(graph), f"the core includes what is not the core: {sorted(set(order) - set(graph))}"


@pytest.mark.parametrize("header", sorted(HEADERS.rglob("*.hpp")), ids=lambda path: path.name)
def test_header_of_the_core_stays_within_its_means(header: Path) -> None:
    foreign = {name for mark, name in includes(header) if mark == "<"} - STANDARD_HEADERS
    assert not foreign, f"{header.name} must do without {sorted(foreign)}"
    code = re.sub(r"//[^\n]*", "", header.read_text())
    forbidden = set(re.findall(r"\b(?:new|delete|malloc|throw|try|virtual|printf)\b", re.sub(r"=\s*delete", "", code)))
    assert not forbidden, f"{header.name} must do without {sorted(forbidden)}"
