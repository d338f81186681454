"""Ten real `fes-robot` processes on a table with bodies in MuJoCo: the formation by counted packets, in real time."""
