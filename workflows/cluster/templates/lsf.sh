#!/bin/bash
#BSUB -J {{job_name}}
#BSUB -o {{log}}
#BSUB -n {{cores}}
{%- if cores > 1 %}
#BSUB -R "span[ptile={{tasks_per_node}}]"
{%- endif %}
#BSUB -R "rusage[mem={{memory_mb}}MB]"
#BSUB -W {{minutes}}
{%- if partition %}
#BSUB -q {{partition}}
{%- endif %}
{%- if account %}
#BSUB -P {{account}}
{%- endif %}
{%- if dependency_list %}
#BSUB -w "ended({{dependency_list | join(') && ended(')}})"
{%- endif %}
{%- if options %}
#BSUB {{options}}
{%- endif %}

{{command}}
