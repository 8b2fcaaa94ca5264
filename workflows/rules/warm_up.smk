# Cold compilation takes longer than any job: do it once, before the fan-out.


rule warm_up:
    input:
        package=PACKAGE,
        code=modules("warm_up"),
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
