# What __getattr__ of __init__.py finds, for those who check types.
from ipcli.api import ActionModel as ActionModel
from ipcli.api import Result as Result
from ipcli.api import fuse as fuse
from ipcli.api import learn as learn
from ipcli.api import open as open
from ipcli.api import read as read
from ipcli.api import recognise as recognise

__version__: str
