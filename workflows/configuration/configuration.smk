# Where things are, and the checked configuration; included first.
import sys
from pathlib import Path

# From the folder of this file: results/ is the repository's, whatever Snakefile is the entry.
ROOT = Path(str(workflow.current_basedir)).resolve().parents[1]


workdir: str(ROOT)


sys.path.insert(0, str(ROOT))

from cfmpm.program import program_files
from workflows.settings import read_settings
from workflows.execution.imports import modules_of
from workflows.execution.job import let_scripts_import
from workflows.execution.lock import clear_after_kill, remove_unfinished
from workflows.study.studies import given_studies

let_scripts_import(ROOT)

# The jobs of a cluster read this file too.
if workflow.is_main_process:
    ALIVE = clear_after_kill(ROOT / ".snakemake")


configfile: str(ROOT / "configs" / "workflow" / "section_5_1.yaml")
configfile: str(ROOT / "configs" / "workflow" / "growth.yaml")
configfile: str(ROOT / "configs" / "workflow" / "large_strain.yaml")
configfile: str(ROOT / "configs" / "workflow" / "work_precision.yaml")
configfile: str(ROOT / "configs" / "workflow" / "scaling.yaml")
configfile: str(ROOT / "configs" / "workflow" / "newton_cost.yaml")
configfile: str(ROOT / "configs" / "workflow" / "study_overhead.yaml")
configfile: str(ROOT / "configs" / "workflow" / "stability.yaml")


# A study that is given as a config file is in the configuration too: first its own mistakes.
GIVEN_STUDIES = given_studies(workflow.overwrite_configfiles)
# Nothing runs on a bad configuration: every scene of every series is checked here.
SETTINGS = read_settings(config)

# Results are computed again when what makes them changes, pictures when plotting does.
PACKAGE = [str(path.relative_to(ROOT)) for path in program_files()]
PLOTTING = sorted(
    str(path.relative_to(ROOT)) for path in ROOT.glob("cfmpm/plotting/*.py")
)

# Blocks of values that studies of the paper name.
PRESCRIBED = ["configs/paper/as_printed.yaml", "configs/paper/best.yaml"]

# What the paper states, which claims quote.
STATEMENTS = sorted(
    str(path.relative_to(ROOT)) for path in ROOT.glob("workflows/statements/*.yaml")
)

# What others have computed. Drawing and deciding take seconds: again when any of it changes.
REFERENCES = sorted(
    str(path.relative_to(ROOT)) for path in ROOT.glob("workflows/reference/*.csv")
)


def modules(job, *measures):
    """The modules that a job's script in jobs/ and the measures of its studies are made of."""
    here = Path(str(workflow.current_basedir))
    paths = [here / f"{name}.py" for name in measures]
    found = {str(path.relative_to(ROOT)) for path in paths}
    for path in (here / "jobs" / f"{job}.py", *paths):
        found |= {*modules_of(path, ROOT)}
    return sorted(found)


def plain(model):
    """What of a model is stored with a result: plain data, so that a change is noticed."""
    return model.model_dump(mode="json", exclude_none=True)


def measured(model):
    """The parameters of a measurement; its scene is an input file."""
    return {key: value for key, value in plain(model).items() if key != "scene"}
