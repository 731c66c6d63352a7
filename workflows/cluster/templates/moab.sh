#!/bin/bash
#MSUB -S /bin/bash
#MSUB -N {{job_name}}
#MSUB -o {{log}}
#MSUB -j oe
#MSUB -V
#MSUB -l nodes={{nodes}}:ppn={{tasks_per_node}}
#MSUB -l mem={{total_memory_mb}}mb
#MSUB -l walltime={{walltime}}
{%- if partition %}
#MSUB -q {{partition}}
{%- endif %}
{%- if account %}
#MSUB -A {{account}}
{%- endif %}
{%- if dependency_list %}
#MSUB -l depend=afterany:{{dependency_list | join(':')}}
{%- endif %}
{%- if options %}
#MSUB {{options}}
{%- endif %}

{{command}}
