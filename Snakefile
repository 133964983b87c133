# SPDX-License-Identifier: GPL-2.0-or-later
"""FloeFlow: from an ice mask to a diagnostic report.

.venv/bin/snakemake --profile workflows/profiles/local --config scene=config/scenes/smoke.yaml
"""

from snakemake.logging import logger
from snakemake.utils import min_version

from floeflow.workflow.terminal import one_line_an_event

min_version("9.0")
# Where the output is no terminal, as in a log, one line an event.
one_line_an_event(logger)


# What `snakemake --report FILE` says first.
report: "workflows/captions/workflow.rst"


include: "workflows/rules/common.smk"


# A scene, or a variant of one: <base>+<study>-<variant>.
wildcard_constraints:
    scene=r"[a-z0-9][a-z0-9_-]*(\+[a-z0-9_-]+)?",
    chunk=r"[0-9]+",


include: "workflows/rules/preprocess.smk"
include: "workflows/rules/simulate.smk"
include: "workflows/rules/postprocess.smk"
include: "workflows/rules/export.smk"
include: "workflows/rules/studies.smk"


rule all:
    default_target: True
    input:
        default_targets(),


onstart:
    SCENES.say_expectation()


onsuccess:
    print(SCENES.closing_line())


onerror:
    SCENES.say_faults()
