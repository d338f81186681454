# One image for every role: fes-world, fes-agent and fes. What must be written goes to /srv/runs or /tmp.
FROM python:3.11-slim-bookworm AS wheel

# The compiler stays in this stage: the image has the wheel, with the compiled core.
ENV PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore
RUN command -v cc || { apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev; }
WORKDIR /source
COPY pyproject.toml build_core.py hatch_build.py README.md LICENSE fes_robots.py ./
COPY fes fes
COPY agents agents
COPY world world
COPY field field
COPY console console
COPY configs configs
RUN FES_CORE=c pip wheel --no-deps -w /wheels .

FROM python:3.11-slim-bookworm

ENV PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore

# The libraries first: they change less often than the source, and are the larger part.
WORKDIR /source
COPY pyproject.toml ./
RUN python -c "import tomllib; project = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
print(*project['dependencies'], *project['optional-dependencies']['security'], sep='\n')" > wanted.txt \
    && pip install -r wanted.txt

COPY --from=wheel /wheels /wheels
RUN pip install --no-deps /wheels/*.whl

# Docker gives a new volume the owner of the folder it is mounted on, so the folders of all volumes are made here.
RUN groupadd --gid 10001 fes && useradd --uid 10001 --gid fes --no-create-home --home-dir /tmp fes \
    && install -d -o fes -g fes /srv/runs \
    && for role in authority world observer operator $(seq -f robot-%g 0 9); do \
        install -d -o fes -g fes -m 700 "/keys/$role"; done
WORKDIR /srv
COPY configs configs
COPY deploy/issue-keys /usr/local/bin/issue-keys
USER fes
CMD ["fes", "--help"]
