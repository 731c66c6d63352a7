#!/bin/bash
# flux: --job-name={{job_name}}
# flux: --output={{log}}
# flux: --nslots={{cores}}
{%- if cores > 1 %}
# flux: --nodes={{nodes}}
{%- endif %}
# flux: --time-limit={{run_time_max}}s
{%- if partition %}
# flux: --queue={{partition}}
{%- endif %}
{%- if account %}
# flux: --bank={{account}}
{%- endif %}
{%- for id in dependency_list or () %}
# flux: --dependency=afterany:{{id}}
{%- endfor %}
{%- if options %}
# flux: {{options}}
{%- endif %}

{{command}}
