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


def item(path, caption, section, name):
    """A result as an item of Snakemake's report.

    Its name is its one label. Of a second one with two values, each in half of a section's
    items, the report makes a switch and takes it that all combinations are there: a section of
    two items empties the page.
    """
    return report(path, caption=caption, category=section, labels={"item": name})


def figure(number, shows, section):
    """A figure of the paper as an item of Snakemake's report."""
    return item(
        f"results/paper/fig{number}.png",
        f"report/fig{number}.rst",
        section,
        # Items are sorted as text: of two digits or one and a blank.
        f"Fig. {number!s:>2}: {shows}",
    )


def claims(page, caption, section):
    """A table of claims as an item of Snakemake's report."""
    return item(page, caption, section, "Claims: what the paper says, what was found")
