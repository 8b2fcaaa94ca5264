# Figures, films and tables of claims: items of Snakemake's report and of the overview.

# What the sections add to the whole, each by its own rules: figures and films to be made, the jobs
# behind them, and tables of claims.
SECTIONS, CLAIMS, FILMS = {}, {}, []


def contribute(section, numbers, jobs):
    """Add figures of the paper and the jobs that are timed."""
    here = Path(str(workflow.current_basedir)).relative_to(ROOT)
    SECTIONS[section] = {
        "figures": {n: f"results/paper/fig{n}.png" for n in numbers},
        "captions": {n: str(here / "report" / f"fig{n}.rst") for n in numbers},
        "benchmarks": {name: f"results/benchmarks/{name}.tsv" for name in jobs},
    }


def figure(number, shows, section):
    """A figure of the paper as an item of Snakemake's report."""
    return report(
        f"results/paper/fig{number}.png",
        caption=f"report/fig{number}.rst",
        category=section,
        labels={"figure": str(number), "shows": shows},
    )


def claims(page, caption, section):
    """A table of claims as an item of Snakemake's report."""
    return report(
        page,
        caption=caption,
        category=section,
        labels={"figure": "table", "shows": "paper, reference, cfmpm"},
    )
