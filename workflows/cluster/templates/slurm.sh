#!/bin/bash
#SBATCH --job-name={{job_name}}
#SBATCH --output={{log}}
#SBATCH --export=ALL
#SBATCH --ntasks={{cores}}
{%- if cores > 1 %}
#SBATCH --nodes={{nodes}}
{%- endif %}
{%- if nodes > 1 %}
#SBATCH --ntasks-per-node={{tasks_per_node}}
{%- endif %}
#SBATCH --time={{minutes}}
#SBATCH --mem={{memory_mb}}
#SBATCH --signal=TERM@{{warning}}
{%- if partition %}
#SBATCH --partition={{partition}}
{%- endif %}
{%- if account %}
#SBATCH --account={{account}}
{%- endif %}
{%- if dependency_list %}
#SBATCH --dependency=afterany:{{dependency_list | join(':')}}
{%- endif %}
{%- if options %}
#SBATCH {{options}}
{%- endif %}

{{command}}
