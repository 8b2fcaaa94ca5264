# Where things are, and the checked configuration; included first.
import sys
from pathlib import Path

# From the folder of this file: results/ is the repository's, whatever Snakefile is the entry.
ROOT = Path(str(workflow.current_basedir)).resolve().parents[1]


workdir: str(ROOT)


sys.path.insert(0, str(ROOT))

from workflows.job import let_scripts_import
from workflows.settings import read_settings

let_scripts_import(ROOT)


configfile: str(ROOT / "configs" / "workflow" / "section_5_1.yaml")
configfile: str(ROOT / "configs" / "workflow" / "growth.yaml")
configfile: str(ROOT / "configs" / "workflow" / "work_precision.yaml")
configfile: str(ROOT / "configs" / "workflow" / "scaling.yaml")


# Nothing runs on a bad configuration: every scene of every series is checked here.
SETTINGS = read_settings(config)
PAPER = SETTINGS.section_5_1
STUDIES = SETTINGS.growth.studies()

# Results are computed again when the package changes, pictures when its plotting does.
MODULES = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("cfmpm/**/*.py"))
PLOTTING = [path for path in MODULES if path.startswith("cfmpm/plotting/")]
PACKAGE = [path for path in MODULES if path not in PLOTTING]


def plain(model):
    """What of a model is stored with a result: plain data, so that a change is noticed."""
    return model.model_dump(mode="json", exclude_none=True)


def measured(model):
    """The parameters of a measurement; its scene is an input file."""
    return {key: value for key, value in plain(model).items() if key != "scene"}


def meshes_of_series(wildcards):
    """The grids of one series."""
    return {
        wanted: plain(mesh) for wanted, mesh in PAPER.series[wildcards.series].items()
    }


def scene_of_study(wildcards):
    return STUDIES[wildcards.study].scene


def variants_of_study(wildcards):
    return STUDIES[wildcards.study].variants


def film_of_study(wildcards):
    """What of a study is filmed: the replaced values of one variant, and how often."""
    study = STUDIES[wildcards.study]
    return {"replaced": study.variants[study.film.variant], "every": study.film.every}
