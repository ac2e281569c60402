# Both commands of the README on a bare system:
#
#   docker build --tag skylimb .
#   docker run --rm skylimb make test
#   docker run --rm --volume "$PWD/out:/skylimb/out" skylimb make demo
FROM python:3.11-slim

# make and a C compiler for the native driver; Mesa draws the videos without a graphics card.
RUN apt-get update \
 && apt-get install --yes --no-install-recommends make gcc libc6-dev libegl1 libgl1-mesa-dri libosmesa6 \
 && rm -rf /var/lib/apt/lists/*

WORKDIR /skylimb
COPY . .
RUN make .venv/dev.stamp
CMD ["make", "demo"]
