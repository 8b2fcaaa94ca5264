# Cold compilation takes longer than most jobs: what all of them need is compiled once, before the
# fan-out. Kernels of growth and of finite deformation are left to the jobs that call them: for all
# others to wait for these would take as long as two jobs take to compile them side by side.


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
        "jobs/warm_up.py"
