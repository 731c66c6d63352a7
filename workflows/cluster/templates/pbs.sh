#!/bin/bash
#PBS -S /bin/bash
#PBS -N {{job_name}}
#PBS -o {{log}}
#PBS -j oe
#PBS -V
#PBS -l select={{nodes}}:ncpus={{tasks_per_node}}:mpiprocs={{tasks_per_node}}:mem={{memory_mb}}mb
#PBS -l walltime={{walltime}}
{%- if partition %}
#PBS -q {{partition}}
{%- endif %}
{%- if account %}
#PBS -A {{account}}
{%- endif %}
{%- if dependency_list %}
#PBS -W depend=afterany:{{dependency_list | join(':')}}
{%- endif %}
{%- if options %}
#PBS {{options}}
{%- endif %}

{{command}}
