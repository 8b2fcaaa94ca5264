# What is asked for by name. A rule's name cannot hold a hyphen, but an anonymous rule's can.
# There is no default target: Snakemake takes none from an included file.

REPRODUCED = [
    *expand("results/paper/fig{n}.png", n=[4, 5, 6, 7, *range(9, 17)]),
    "results/paper/section_5_1.html",
    "results/paper/sections_5_2_to_5_5.html",
    *expand("results/paper/{study}.gif", study=STUDIES),
]


rule:
    name:
        "reproduce-paper"
    input:
        REPRODUCED,
    message:
        "The paper is reproduced: see results/paper"


rule reproduce_paper:
    input:
        REPRODUCED,


rule:
    name:
        "work-precision"
    input:
        "results/performance/work_precision.png",


rule work_precision:
    input:
        "results/performance/work_precision.png",


rule scaling:
    input:
        "results/performance/scaling.png",
