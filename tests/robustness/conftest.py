"""Options of the robustness tests: quick by default, as long as one likes by hand."""


def pytest_addoption(parser):
    group = parser.getgroup("robustness")
    group.addoption("--kills", type=int, default=6, help="points at which a run is killed (test_kill.py)")
    group.addoption("--disks", type=int, default=4, help="sizes of the disk that fills (test_disk_full.py)")
    group.addoption("--campaign-runs", type=int, default=12, help="runs of the campaigns (test_campaigns.py)")
    group.addoption("--soak-updates", type=int, default=4000, help="updates of the long run (test_soak.py)")
    group.addoption("--soak-cycles", type=int, default=10, help="files opened, played and closed (test_soak.py)")
    group.addoption("--seed", type=int, default=0, help="seed of the random points")
