"""Programs that tests start or observe: a browser, a cluster, the command line, scripts."""
