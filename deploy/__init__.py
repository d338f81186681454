"""The parts of a deployment.

wheels      the files of a release, for each platform
systemd     units for a world and agents as services
issue-keys  the certificates of compose.yaml
"""
