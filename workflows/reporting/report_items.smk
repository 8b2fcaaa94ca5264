# Figures, films and tables of claims: items of Snakemake's report and of the overview.

# What the sections add to the whole, each by its own rules: figures and films to be made, with
# their captions, from what, by which jobs; and tables of claims.
SECTIONS, CLAIMS, FILMS, CAPTIONS = {}, [], [], []


FILM = "the cracks as they grow"


def contribute(section, figures, jobs, of, film=None, extra={}):
    """Add figures of the paper and a film, jobs that are timed together, and what has the scene.

    A figure has by its number a title, and in short what the paper's figure shows. Extra figures
    are beyond the paper: they have by the name of their file a title.
    """
    report_folder = Path(str(workflow.current_basedir)).relative_to(ROOT) / "report"
    files = {str(number): f"fig{number}" for number in figures}
    titles = {str(number): texts for number, texts in figures.items()}
    files |= {name: name for name in extra}
    titles |= {name: (title, "") for name, title in extra.items()}
    drawn = {
        name: {
            "title": title,
            "paper": paper,
            "picture": f"results/paper/{files[name]}.png",
            "data": f"results/paper/{files[name]}.nc",
            "caption": str(report_folder / f"{files[name]}.rst"),
        }
        for name, (title, paper) in titles.items()
    }
    filmed = {
        "title": FILM,
        "picture": f"results/paper/film_{film}.png",
        "file": f"results/paper/{film}.gif",
        "caption": str(report_folder / "film.rst"),
    }
    films = [filmed] if film else []
    SECTIONS[section] = {
        "figures": drawn,
        "films": films,
        "benchmarks": {
            done: [f"results/benchmarks/{one}.tsv" for one in together]
            for done, together in jobs.items()
        },
        "scene": of.scene,
        "study": of.study,
    }
    CAPTIONS.extend(one["caption"] for one in (*drawn.values(), *films))
    FILMS.extend(one[file] for one in films for file in ("picture", "file"))


def item(path, caption, section, name):
    """A result as an item of Snakemake's report.

    Its name is its one label. Of a second one with two values, each in half of a section's
    items, the report makes a switch and takes it that all combinations are there: a section of
    two items empties the page.
    """
    return report(path, caption=caption, category=section, labels={"item": name})


def figure(name, section):
    """A figure of the paper, by its number, or an extra one as an item of Snakemake's report."""
    shown = SECTIONS[section]["figures"][str(name)]
    # Items are sorted as text: of two digits or one and a blank.
    kind = f"Fig. {name!s:>2}" if shown["paper"] else "Beyond the paper"
    return item(
        shown["picture"],
        f"report/{Path(shown['caption']).name}",
        section,
        f"{kind}: {shown['title']}",
    )


def claims(page, caption, section):
    """A table of claims as an item of Snakemake's report."""
    return item(page, caption, section, "Claims: what the paper says, what was found")
