"""Programs that tests start or look at: a browser, a cluster, the command line, scripts."""
