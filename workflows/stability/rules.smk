# The stability study: extreme cases, what happened in each, one page.


rule stability_data:
    # One job: most cases take a second.
    input:
        scene=SETTINGS.stability.scene,
        compiled=rules.warm_up.output.stamp,
        code=modules("stability_data", "path_of_load"),
    output:
        data="results/stability/cases.nc",
    log:
        "results/logs/stability_data.log",
    benchmark:
        "results/benchmarks/stability_data.tsv"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        settings=plain(SETTINGS.stability),
    message:
        "Extreme cases"
    script:
        "jobs/stability_data.py"


rule stability_page:
    input:
        data=rules.stability_data.output.data,
        code=[*modules("stability_page"), *PLOTTING],
    output:
        errors="results/stability/errors.png",
        paths="results/stability/paths.png",
        page=item(
            "results/stability/stability.html",
            "report/stability.rst",
            "Stability",
            "Extreme cases",
        ),
    log:
        "results/logs/stability_page.log",
    benchmark:
        "results/benchmarks/stability_page.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        titles={name: group.title for name, group in SETTINGS.stability.groups.items()},
    message:
        "Extreme cases on one page"
    script:
        "jobs/stability_page.py"
