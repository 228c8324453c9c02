// The picture: clean and damaged with a line to drag between them, cracks drawn over it, and stones that
// are thrown at it.

import { useEffect, useRef, useState } from "preact/hooks";
import type { Box } from "./answers";
import type { Boxes } from "./detector";
import { hitAt, type Hit } from "./state";

export interface Pixels {
  width: number;
  height: number;
  bytes: Uint8Array<ArrayBuffer>;
}

export type Look = "damaged" | "swipe" | "clean" | "region" | "crack" | "arrival" | "stress" | "depth";

interface Props {
  clean: Pixels | null;
  damaged: Pixels | null;
  mask: ImageBitmap | null;
  cracks: Float32Array | null;
  look: Look;
  boxes: Boxes | null;
  hits: Hit[];
  label: string;
  onHit(hit: Hit, isDraft: boolean): void;
  /** A throw that was broken off. */
  onCancel(): void;
}

/** Speed of a stone per share of the picture's width that it is dragged over, m/s. */
const SPEED_PER_WIDTH = 120;
const NUMBERS_OF_A_PIECE = 7;
const COLUMN = { arrival: 4, stress: 5, depth: 6 } as const;

export function Stage(props: Props) {
  const { clean, damaged, mask, cracks, look, boxes, hits, onHit } = props;
  const canvas = useRef<HTMLCanvasElement>(null);
  const [swipe, setSwipe] = useState(0.5);
  const [aim, setAim] = useState<[number, number, number, number] | null>(null);
  const [cursor, setCursor] = useState<[number, number]>([0.5, 0.5]);
  const [hasCursor, setHasCursor] = useState(false);
  const shown = damaged ?? clean;

  useEffect(() => {
    const context = canvas.current?.getContext("2d");
    if (!context || !clean || !shown) return;
    const { width, height } = clean;
    const image = (pixels: Pixels) => new ImageData(new Uint8ClampedArray(pixels.bytes.buffer), pixels.width, pixels.height);
    context.canvas.width = width;
    context.canvas.height = height;
    context.putImageData(image(look === "clean" ? clean : shown), 0, 0);
    if (look === "swipe") {
      const at = Math.round(swipe * width);
      context.putImageData(image(clean), 0, 0, 0, 0, at, height);
      context.fillStyle = "#fff";
      context.fillRect(at - 1, 0, 2, height);
    }
    if ((look === "region" || look === "crack") && mask) {
      context.globalAlpha = 0.75;
      context.drawImage(mask, 0, 0);
      context.globalAlpha = 1;
    }
    if ((look === "arrival" || look === "stress" || look === "depth") && cracks) draw(context, cracks, COLUMN[look]);
  }, [clean, shown, mask, cracks, look, swipe]);

  const place = (event: PointerEvent): [number, number] => {
    const box = canvas.current!.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const hit = ([x0, y0, x1, y1]: [number, number, number, number]): Hit => {
    const box = canvas.current!.getBoundingClientRect();
    const [dx, dy] = [(x1 - x0) * box.width, (y1 - y0) * box.height];
    const length = Math.hypot(dx, dy);
    if (length < 8) return hitAt(x0, y0);
    const speed = Math.min(Math.max((length / box.width) * SPEED_PER_WIDTH, 2), 100);
    return hitAt(x0, y0, { azimuth: (Math.atan2(dy, dx) * 180) / Math.PI, speed });
  };
  const swipes = look === "swipe";

  const ratio = (clean?.width ?? 1242) / (clean?.height ?? 375);
  return (
    <div class="stage" style={{ maxWidth: `${72 * ratio}vh` }}>
      <canvas
        ref={canvas}
        width={clean?.width ?? 1242}
        height={clean?.height ?? 375}
        tabIndex={0}
        role="application"
        aria-label={props.label}
        onFocus={(event) => setHasCursor((event.currentTarget as HTMLElement).matches(":focus-visible"))}
        onBlur={() => setHasCursor(false)}
        onPointerDown={(event) => {
          if (!clean || event.button !== 0) return;
          canvas.current!.setPointerCapture(event.pointerId);
          const [x, y] = place(event);
          if (swipes) return setSwipe(x);
          setAim([x, y, x, y]);
          onHit(hitAt(x, y), true);
        }}
        onPointerMove={(event) => {
          const [x, y] = place(event);
          if (swipes && event.buttons === 1) setSwipe(Math.min(Math.max(x, 0), 1));
          if (!aim) return;
          const next: typeof aim = [aim[0], aim[1], x, y];
          setAim(next);
          onHit(hit(next), true);
        }}
        onPointerUp={(event) => {
          if (!aim) return;
          const [x, y] = place(event);
          onHit(hit([aim[0], aim[1], x, y]), false);
          setAim(null);
        }}
        onPointerCancel={() => {
          setAim(null);
          props.onCancel();
        }}
        onKeyDown={(event) => {
          const steps: Record<string, [number, number]> = {
            ArrowLeft: [-0.02, 0],
            ArrowRight: [0.02, 0],
            ArrowUp: [0, -0.04],
            ArrowDown: [0, 0.04],
          };
          const step = steps[event.key];
          if (step) {
            event.preventDefault();
            if (swipes) return setSwipe((at) => Math.min(Math.max(at + step[0], 0), 1));
            setCursor(([x, y]) => [Math.min(Math.max(x + step[0], 0), 1), Math.min(Math.max(y + step[1], 0), 1)]);
            setHasCursor(true);
          } else if ((event.key === "Enter" || event.key === " ") && !swipes) {
            event.preventDefault();
            onHit(hitAt(...cursor), false);
          }
        }}
      />
      {boxes?.clean && clean && (look === "clean" || swipes) && (
        <Marks boxes={boxes.clean} of={clean} from={0} to={swipes ? swipe : 1} />
      )}
      {boxes?.damaged && clean && look !== "clean" && (
        <>
          {boxes.clean && <Marks boxes={boxes.clean} of={clean} from={swipes ? swipe : 0} to={1} wasThere />}
          <Marks boxes={boxes.damaged} of={clean} from={swipes ? swipe : 0} to={1} />
        </>
      )}
      <svg class="aim" viewBox="0 0 1000 1000" preserveAspectRatio="none" aria-hidden="true">
        {hasCursor && !swipes && (
          <path d={`M${cursor[0] * 1000 - 12} ${cursor[1] * 1000}h24m-12 -40v80`} vector-effect="non-scaling-stroke" />
        )}
        {aim && (
          <path
            d={`M${aim[0] * 1000} ${aim[1] * 1000}L${aim[2] * 1000} ${aim[3] * 1000}`}
            vector-effect="non-scaling-stroke"
          />
        )}
      </svg>
      <p class="said" aria-live="polite">
        {hits.length > 0 ? `${hits.length} hit${hits.length > 1 ? "s" : ""}` : ""}
      </p>
    </div>
  );
}

interface MarksProps {
  boxes: Box[];
  of: Pixels;
  from: number;
  to: number;
  /** Found in the clean picture: without its damaged twin it is lost. */
  wasThere?: boolean;
}

/** Boxes of a detector, over a part of the picture's width. */
function Marks({ boxes, of, from, to, wasThere }: MarksProps) {
  const share = (value: number) => `${value * 100}%`;
  return (
    <div class={wasThere ? "marks were" : "marks"} style={{ clipPath: `inset(0 ${share(1 - to)} 0 ${share(from)})` }} aria-hidden="true">
      {boxes.map(({ class: name, score, corners_px: [x0, y0, x1, y1] }) => (
        <div
          style={{
            left: share(x0 / of.width),
            top: share(y0 / of.height),
            width: share((x1 - x0) / of.width),
            height: share((y1 - y0) / of.height),
          }}
        >
          {!wasThere && <span>{name ?? "?"} {score.toFixed(2)}</span>}
        </div>
      ))}
    </div>
  );
}

/** The pieces of cracks in colors from the least to the greatest of a column. */
function draw(context: CanvasRenderingContext2D, cracks: Float32Array, column: number) {
  const n = cracks.length / NUMBERS_OF_A_PIECE;
  const values: number[] = [];
  for (let k = 0; k < n; k += 1) values.push(cracks[k * NUMBERS_OF_A_PIECE + column]!);
  // By rank: times lie over many powers of ten.
  const order = values.map((_, k) => k).sort((a, b) => values[a]! - values[b]!);
  const rank = new Array<number>(n);
  order.forEach((k, place) => (rank[k] = n > 1 ? place / (n - 1) : 0));
  context.lineCap = "round";
  for (const width of [4, 2]) {
    context.lineWidth = width;
    for (let k = 0; k < n; k += 1) {
      const [x0, y0, x1, y1] = cracks.subarray(k * NUMBERS_OF_A_PIECE, k * NUMBERS_OF_A_PIECE + 4);
      context.strokeStyle = width === 4 ? "#0008" : Number.isNaN(values[k]) ? "#fff" : `hsl(${260 - 220 * rank[k]!} 90% ${45 + 25 * rank[k]!}%)`;
      context.beginPath();
      context.moveTo(x0!, y0!);
      context.lineTo(x1!, y1!);
      context.stroke();
    }
  }
}
