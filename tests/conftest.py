pytest_plugins = ["stackdsl.pytest_plugin", "pytester"]
