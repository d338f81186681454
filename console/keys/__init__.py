"""Certificates of a secured run.

command       the command fes keys
certificates  certificates and private keys
stale_keys    private keys that killed runs left behind
"""
