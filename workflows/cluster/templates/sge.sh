#!/bin/bash
#$ -S /bin/bash
#$ -N {{job_name}}
#$ -cwd
#$ -o {{log}}
#$ -j y
#$ -V
{%- if cores > 1 %}
#$ -pe {{parallel_environment}} {{cores}}
{%- endif %}
#$ -l h_rt={{run_time_max}}
#$ -l mem_free={{(memory_mb + tasks_per_node - 1) // tasks_per_node}}M
{%- if partition %}
#$ -q {{partition}}
{%- endif %}
{%- if account %}
#$ -P {{account}}
{%- endif %}
{%- if dependency_list %}
#$ -hold_jid {{dependency_list | join(',')}}
{%- endif %}
{%- if options %}
#$ {{options}}
{%- endif %}

{{command}}
