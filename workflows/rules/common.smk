# Where things are, and the checked configuration; included first.
import os
import sys
from pathlib import Path

# From the folder of this file: results/ is the repository's, whatever Snakefile is the entry.
ROOT = Path(str(workflow.current_basedir)).resolve().parents[1]


workdir: str(ROOT)


# Scripts run in processes of their own and import cfmpm and workflows from this checkout.
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(ROOT), os.environ.get("PYTHONPATH")])
)
sys.path.insert(0, str(ROOT))

from workflows.settings import read_settings


configfile: str(ROOT / "configs" / "workflow" / "section_5_1.yaml")
configfile: str(ROOT / "configs" / "workflow" / "work_precision.yaml")
configfile: str(ROOT / "configs" / "workflow" / "scaling.yaml")


# Nothing runs on a bad configuration: every scene of every series is checked here.
os.chdir(ROOT)
SETTINGS = read_settings(config)
PAPER = SETTINGS.section_5_1

PACKAGE = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("cfmpm/**/*.py"))


def plain(model):
    """What of a model is stored with a result: plain data, so that a change is noticed."""
    return model.model_dump(mode="json", exclude_none=True)


rule warm_up:
    # Cold compilation takes longer than any job: do it once, before the fan-out.
    input:
        package=PACKAGE,
    output:
        stamp="results/.compiled",
    log:
        "results/logs/warm_up.log",
    benchmark:
        "results/benchmarks/warm_up.tsv"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=5,
    message:
        "Compiling the kernels"
    script:
        "../scripts/warm_up.py"
