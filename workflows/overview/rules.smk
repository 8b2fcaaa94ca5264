# One page of the whole: each figure beside its claims, with their errors and verdicts.


rule overview:
    input:
        figures=[
            one["picture"] for s in SECTIONS.values() for one in s["figures"].values()
        ],
        films=FILMS,
        benchmarks=[
            path
            for s in SECTIONS.values()
            for together in s["benchmarks"].values()
            for path in together
        ],
        tables=CLAIMS,
        captions=CAPTIONS,
        code=modules("overview"),
    output:
        page="results/paper/overview.html",
        # The report cannot show a page of this size.
        summary=item(
            "results/paper/summary.html",
            "report/overview.rst",
            "5 All claims",
            "What holds and what does not",
        ),
    log:
        "results/logs/overview.log",
    benchmark:
        "results/benchmarks/overview.tsv"
    threads: 1
    resources:
        mem_mb=500,
        runtime=5,
    params:
        sections=SECTIONS,
        tables=CLAIMS,
    message:
        "One page of all figures and claims"
    script:
        "jobs/overview.py"
