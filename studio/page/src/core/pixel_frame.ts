// The binary frames that carry pixels: 32 bytes little-endian, then rows from the top.

export const HEADER_BYTES = 32;
const MAGIC = 0x58505354; // "TSPX"

export const enum FrameKind {
  Tile = 0,
  Whole = 1,
  Parts = 2,
  Chunk = 3,
  Pinned = 4,
  Difference = 5,
}

export interface PixelFrame {
  kind: number;
  /** Whether the body is deflated, without a header. */
  deflated: boolean;
  pane: number;
  scale: number;
  serial: number;
  x: number;
  y: number;
  width: number;
  height: number;
  pictureWidth: number;
  pictureHeight: number;
  version: number;
  samples: number;
  /** The last piece of its pass. */
  endsPass: boolean;
  /** A piece of the last pass. */
  lastPass: boolean;
  body: Uint8Array<ArrayBuffer>;
}

/** The frame in `bytes`; nothing where they are none, or one that reaches out of its picture. */
export function decodeFrame(bytes: ArrayBuffer): PixelFrame | undefined {
  if (bytes.byteLength < HEADER_BYTES) return undefined;
  const view = new DataView(bytes);
  if (view.getUint32(0, true) !== MAGIC) return undefined;
  const flags = view.getUint16(30, true);
  const frame: PixelFrame = {
    kind: view.getUint8(4),
    deflated: view.getUint8(5) === 1,
    pane: view.getUint8(6),
    scale: view.getUint8(7),
    serial: view.getUint32(8, true),
    x: view.getUint16(12, true),
    y: view.getUint16(14, true),
    width: view.getUint16(16, true),
    height: view.getUint16(18, true),
    pictureWidth: view.getUint16(20, true),
    pictureHeight: view.getUint16(22, true),
    version: view.getUint32(24, true),
    samples: view.getUint16(28, true),
    endsPass: (flags & 1) !== 0,
    lastPass: (flags & 2) !== 0,
    body: new Uint8Array(bytes, HEADER_BYTES),
  };
  const inside =
    frame.scale > 0 &&
    frame.x + frame.width <= frame.pictureWidth &&
    frame.y + frame.height <= frame.pictureHeight;
  return inside || frame.kind === FrameKind.Chunk ? frame : undefined;
}

/** The bytes of a chunk of a file that the page sends. */
export function encodeChunk(number: number, isLast: boolean, bytes: ArrayBuffer): ArrayBuffer {
  return encodeFrame({
    kind: FrameKind.Chunk, deflated: false, pane: 0, scale: 0, serial: number, x: 0, y: 0, width: 0, height: 0,
    pictureWidth: 0, pictureHeight: 0, version: 0, samples: 0, endsPass: isLast, lastPass: false, body: new Uint8Array(bytes),
  });
}

/** The frame as bytes. */
export function encodeFrame(frame: PixelFrame): ArrayBuffer {
  const bytes = new ArrayBuffer(HEADER_BYTES + frame.body.length);
  const view = new DataView(bytes);
  view.setUint32(0, MAGIC, true);
  view.setUint8(4, frame.kind);
  view.setUint8(5, frame.deflated ? 1 : 0);
  view.setUint8(6, frame.pane);
  view.setUint8(7, frame.scale);
  view.setUint32(8, frame.serial, true);
  view.setUint16(12, frame.x, true);
  view.setUint16(14, frame.y, true);
  view.setUint16(16, frame.width, true);
  view.setUint16(18, frame.height, true);
  view.setUint16(20, frame.pictureWidth, true);
  view.setUint16(22, frame.pictureHeight, true);
  view.setUint32(24, frame.version, true);
  view.setUint16(28, frame.samples, true);
  view.setUint16(30, (frame.endsPass ? 1 : 0) | (frame.lastPass ? 2 : 0), true);
  new Uint8Array(bytes, HEADER_BYTES).set(frame.body);
  return bytes;
}
