// Frames of a camera, one after the other as fast as the glass is put over them.

import { useEffect } from "preact/hooks";
import { Trouble } from "./desk";
import type { Pixels } from "./stage";

interface Props {
  /** The first frame, as the bytes of a PNG file: the glass is broken before it. */
  onPicture(bytes: Pixels["bytes"]): Promise<void>;
  /** Puts the glass over a frame; null while there is none. */
  through(frame: Pixels): Promise<Pixels | null>;
  onMoment(clean: Pixels, damaged: Pixels): void;
  onEnd(): void;
  onFailure(error: unknown): void;
}

export function Webcam({ onPicture, through, onMoment, onEnd, onFailure }: Props) {
  useEffect(() => {
    let isOver = false;
    let stream: MediaStream | null = null;
    const stop = () => stream?.getTracks().forEach((track) => track.stop());
    const run = async () => {
      if (!navigator.mediaDevices) throw new Trouble("this browser gives no camera to a page that is not served safely");
      stream = await navigator.mediaDevices.getUserMedia({ video: { width: { ideal: 1280 } } }).catch((error: Error) => {
        throw new Trouble(`no camera: ${error.message}`);
      });
      // It was stopped while the browser asked.
      if (isOver) return stop();
      stream.getTracks().forEach((track) => {
        track.onended = () => !isOver && onFailure(new Trouble("the camera has gone"));
      });
      const video = document.createElement("video");
      video.muted = true;
      video.srcObject = stream;
      await video.play();
      const canvas = document.createElement("canvas");
      canvas.width = video.videoWidth;
      canvas.height = video.videoHeight;
      const context = canvas.getContext("2d", { willReadFrequently: true })!;
      context.drawImage(video, 0, 0);
      const first = await new Promise<Blob | null>((done) => canvas.toBlob(done, "image/png"));
      if (first && !isOver) await onPicture(new Uint8Array(await first.arrayBuffer()));
      while (!isOver) {
        context.drawImage(video, 0, 0);
        const { width, height, data } = context.getImageData(0, 0, canvas.width, canvas.height);
        const frame = { width, height, bytes: new Uint8Array(data.buffer) };
        const damaged = await through(frame);
        if (damaged && !isOver) onMoment(frame, damaged);
        await new Promise((done) => requestAnimationFrame(done));
      }
    };
    run().catch((error) => {
      if (!isOver) onFailure(error);
    });
    return () => {
      isOver = true;
      stop();
      onEnd();
    };
  }, []);
  return null;
}
