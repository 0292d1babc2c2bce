"""Programs while they are being written: a workspace of files and unsaved texts, a snapshot of each after every edit,
and jobs of which the latest wins. What a person works in asks here, so that no two of them can disagree.
"""

from porelang.session.jobs import Job, Jobs
from porelang.session.session import Session
from porelang.session.snapshot import Snapshot
from porelang.session.workspace import Workspace

__all__ = ["Job", "Jobs", "Session", "Snapshot", "Workspace"]
