# One page of the whole: each figure beside its claims, with their errors and verdicts.


rule overview:
    input:
        figures=[path for s in SECTIONS.values() for path in s["figures"].values()],
        benchmarks=[
            path for s in SECTIONS.values() for path in s["benchmarks"].values()
        ],
        tables=list(CLAIMS.values()),
        captions=[path for s in SECTIONS.values() for path in s["captions"].values()],
        code=modules("overview"),
    output:
        page=item(
            "results/paper/overview.html",
            "report/overview.rst",
            "5 All figures and claims",
            "All figures and claims",
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
