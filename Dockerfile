# The command, built from this source, in an image of some 120 MB:
#
#   docker build -t starbreak .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" starbreak crack photo.png -o out
#
# Clips need ffmpeg, with which the image is some 680 MB larger, so it is left out unless asked for:
# `docker build --build-arg FFMPEG=yes`.

FROM docker.io/library/rust:1.95-slim-trixie AS build
WORKDIR /source
COPY . .
RUN cargo build --locked --profile dist --package starbreak-cli \
    && mkdir -p /out/licences \
    && cp target/dist/starbreak /out/ \
    && cp LICENSE-MIT LICENSE-APACHE /out/licences/ \
    && cargo xtask notices > /out/licences/LICENSE-THIRD-PARTY.txt

# The same Debian, so that the C library is the same.
FROM docker.io/library/debian:trixie-slim
ARG FFMPEG=no
RUN if [ "$FFMPEG" = yes ]; then \
        apt-get update \
        && apt-get install --yes --no-install-recommends ffmpeg \
        && rm -rf /var/lib/apt/lists/*; \
    fi \
    && useradd --uid 10001 --no-create-home starbreak \
    && install --directory --owner starbreak /work
COPY --from=build /out/licences /usr/local/share/doc/starbreak/
COPY --from=build /out/starbreak /usr/local/bin/
USER starbreak
WORKDIR /work
ENTRYPOINT ["starbreak"]
CMD ["help"]
