"""What a deployment is made of.

wheels      the files of a release, for each platform
systemd     units for a world and agents as services
issue-keys  the certificates of compose.yaml
"""
