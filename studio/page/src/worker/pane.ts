// One pane's canvas. What it shows is kept as bytes too, since a canvas gives no exact ones back.

import { Picture } from "../core/picture.js";
import type { PixelFrame } from "../core/pixel_frame.js";
import type { Painted } from "./messages.js";

const REPORT_MS = 16;

export class Pane {
  readonly picture = new Picture();
  size: [number, number] = [0, 0];
  private context: OffscreenCanvasRenderingContext2D | null = null;
  private reported = -1;
  private due: ReturnType<typeof setTimeout> | undefined;
  private next: Painted | undefined;

  constructor(
    private readonly number: number,
    private readonly report: (painted: Painted) => void = () => {},
  ) {}

  attach(canvas: OffscreenCanvas): void {
    this.context = canvas.getContext("2d");
    this.show(0, 0, this.picture.width, this.picture.height);
  }

  paint(frame: PixelFrame, rows: Uint8Array): void {
    const changed = this.picture.paint(frame, rows, ...this.size);
    if (!changed) return;
    this.show(changed.x, changed.y, changed.width, changed.height);
    this.tell(frame);
  }

  private show(x: number, y: number, width: number, height: number): void {
    if (!this.context || width === 0 || height === 0) return;
    const { canvas } = this.context;
    if (canvas.width !== this.picture.width || canvas.height !== this.picture.height) {
      canvas.width = this.picture.width;
      canvas.height = this.picture.height;
      [x, y, width, height] = [0, 0, this.picture.width, this.picture.height];
    }
    const image = new ImageData(this.picture.pixels as Uint8ClampedArray<ArrayBuffer>, this.picture.width, this.picture.height);
    this.context.putImageData(image, 0, 0, x, y, width, height);
  }

  /** The first piece of a picture and its end are told at once, what lies between once a frame. */
  private tell(frame: PixelFrame): void {
    const { picture } = this;
    this.next = {
      pane: this.number,
      serial: picture.serial,
      version: picture.version,
      scale: picture.scale,
      samples: picture.samples,
      width: picture.width,
      height: picture.height,
      endsPass: frame.endsPass,
      complete: picture.complete,
    };
    if (this.reported !== picture.serial || frame.endsPass) this.flush();
    else this.due ??= setTimeout(() => this.flush(), REPORT_MS);
  }

  private flush(): void {
    if (this.due !== undefined) clearTimeout(this.due);
    this.due = undefined;
    if (!this.next) return;
    this.reported = this.next.serial;
    this.report(this.next);
    this.next = undefined;
  }
}
