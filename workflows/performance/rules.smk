# Run time against error and against size.

WORK = SETTINGS.work_precision


rule work_precision_data:
    # CPU time of one thread: other work on the machine does not disturb it.
    input:
        scenes=sorted(
            {
                problem.scene
                for problem in (*WORK.stationary.values(), *WORK.paths.values())
            }
        ),
        compiled=rules.warm_up.output.stamp,
        references=sorted(
            {
                f"workflows/reference/{name}.csv"
                for problem in WORK.paths.values()
                for name in (problem.reference, problem.release)
                if name is not None
            }
        ),
        code=modules("work_precision_data", "timed_run"),
    output:
        data="results/performance/work_precision.nc",
    log:
        "results/logs/performance/work_precision.log",
    benchmark:
        "results/benchmarks/performance/work_precision.tsv"
    threads: 1
    resources:
        mem_mb=3000,
        runtime=30,
    params:
        **WORK.model_dump(mode="json"),
    message:
        "Measuring error against run time; takes minutes"
    script:
        "jobs/work_precision_data.py"


rule work_precision_figures:
    input:
        data=rules.work_precision_data.output.data,
        code=[*modules("work_precision_figures"), *PLOTTING],
    output:
        errors=item(
            "results/performance/work_precision.png",
            "report/work_precision.rst",
            "Performance",
            "Error against CPU time",
        ),
        paths=item(
            "results/performance/paths.png",
            "report/paths.rst",
            "Performance",
            "Growing cracks: error against CPU time",
        ),
        grading=item(
            "results/performance/grading.png",
            "report/grading.rst",
            "Performance",
            "Grading: element sizes, growth, radius",
        ),
        solvers=item(
            "results/performance/solvers.png",
            "report/solvers.rst",
            "Performance",
            "Solvers: cfmpm and scikit-fem",
        ),
        page=item(
            "results/performance/defaults.html",
            "report/defaults.rst",
            "Performance",
            "Defaults that follow",
        ),
    log:
        "results/logs/performance/work_precision_figures.log",
    benchmark:
        "results/benchmarks/performance/work_precision_figures.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Drawing error against run time; which defaults follow"
    script:
        "jobs/work_precision_figures.py"


rule scaling_data:
    input:
        scene=SETTINGS.scaling.scene,
        compiled=rules.warm_up.output.stamp,
        code=modules("scaling_data"),
    output:
        data="results/performance/scaling.nc",
    log:
        "results/logs/performance/scaling.log",
    benchmark:
        "results/benchmarks/performance/scaling.tsv"
    # All cores: nothing else may run beside a measurement of wall time.
    threads: workflow.cores or 1
    resources:
        mem_mb=6000,
        runtime=60,
    params:
        **measured(SETTINGS.scaling),
    message:
        "Measuring run time against size; takes minutes"
    script:
        "jobs/scaling_data.py"


rule scaling_figure:
    input:
        data=rules.scaling_data.output.data,
        code=[*modules("scaling_figure"), *PLOTTING],
    output:
        picture=item(
            "results/performance/scaling.png",
            "report/scaling.rst",
            "Performance",
            "Run time against size",
        ),
    log:
        "results/logs/performance/scaling_figure.log",
    benchmark:
        "results/benchmarks/performance/scaling_figure.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Drawing run time against size"
    script:
        "jobs/scaling_figure.py"


rule newton_cost:
    input:
        scene=SETTINGS.newton_cost.scene,
        compiled=rules.warm_up.output.stamp,
        code=modules("newton_cost"),
    output:
        data="results/performance/newton_cost.nc",
    log:
        "results/logs/performance/newton_cost.log",
    benchmark:
        "results/benchmarks/performance/newton_cost.tsv"
    threads: 1
    resources:
        mem_mb=3000,
        runtime=10,
    params:
        **measured(SETTINGS.newton_cost),
    message:
        "Measuring an iteration of Newton's method"
    script:
        "jobs/newton_cost.py"


rule study_overhead:
    input:
        scene=SETTINGS.study_overhead.scene,
        compiled=rules.warm_up.output.stamp,
        code=modules("study_overhead"),
    output:
        data="results/performance/study_overhead.nc",
    log:
        "results/logs/performance/study_overhead.log",
    benchmark:
        "results/benchmarks/performance/study_overhead.tsv"
    # As many processes as it measures: nothing else may run beside.
    threads: workflow.cores or 1
    resources:
        mem_mb=3000,
        runtime=10,
    params:
        **measured(SETTINGS.study_overhead),
    message:
        "Measuring what a study adds to its members"
    script:
        "jobs/study_overhead.py"
