# What is asked for by name. A rule's name cannot hold a hyphen, but an anonymous rule's can.

REPRODUCED = [*rules.overview.input.figures, *FILMS, *rules.overview.output]


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
        rules.work_precision_figures.output.page,


rule work_precision:
    input:
        rules.work_precision_figures.output.page,


rule scaling:
    input:
        "results/performance/scaling.png",


rule:
    name:
        "newton-cost"
    input:
        rules.newton_cost.output.data,


rule:
    name:
        "study-overhead"
    input:
        rules.study_overhead.output.data,


rule stability:
    input:
        rules.stability_page.output.page,
