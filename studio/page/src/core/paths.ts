/** The last part of a path. */
export function baseName(path: string): string {
  return path.slice(path.lastIndexOf("/") + 1);
}

/** The ending without its dot, in lower case. */
export function endingOf(path: string): string {
  const name = baseName(path);
  const dot = name.lastIndexOf(".");
  return dot <= 0 ? "" : name.slice(dot + 1).toLowerCase();
}

const SCENE_ENDINGS = new Set(["tessera", "tesserab", "json", "crt", "x3d", "x3dv", "wrl", "gltf", "glb", "obj", "ply", "stl"]);

/** Whether a view can show the file on its own. */
export function isScene(path: string): boolean {
  return SCENE_ENDINGS.has(endingOf(path));
}

const MODEL_ENDINGS = new Set(["obj", "ply", "stl", "gltf", "glb"]);

/** Whether the file is geometry that scenes place. */
export function isModelFile(path: string): boolean {
  return MODEL_ENDINGS.has(endingOf(path));
}

const COMPANION_ENDINGS = new Set(["mtl", "bin"]);

/** Whether the file holds materials or numbers of a model: models name it, scenes do not include it. */
export function isCompanion(path: string): boolean {
  return COMPANION_ENDINGS.has(endingOf(path));
}

/** The folder that the file lies in, with the slash at its end; empty for the opened folder itself. */
export function folderOf(path: string): string {
  return path.slice(0, path.lastIndexOf("/") + 1);
}

/** The name of a file of the opened folder as a text in another folder of it says it. */
export function relativeName(folder: string, name: string): string {
  const from = folder.split("/").slice(0, -1), to = name.split("/");
  let same = 0;
  while (same < from.length && same < to.length - 1 && from[same] === to[same]) ++same;
  return "../".repeat(from.length - same) + to.slice(same).join("/");
}

/** The file of the opened folder that a text in `folder` means by a relative name; nothing where it leads out of the opened folder. */
export function resolvedName(folder: string, name: string): string | undefined {
  const parts: string[] = [];
  for (const part of (folder + name).split("/")) {
    if (part === "..") {
      if (parts.pop() === undefined) return undefined;
    } else if (part !== "." && part !== "") parts.push(part);
  }
  return parts.join("/");
}

export function isPicture(path: string): boolean {
  return PICTURE_ENDINGS.has(endingOf(path));
}

const PICTURE_ENDINGS = new Set(["png", "jpg", "jpeg", "exr", "hdr", "tif", "tiff", "pfm", "ppm", "pgm", "tga", "bmp", "gif", "apng", "webp"]);
const BINARY_ENDINGS = new Set(["tesserab", "glb", "bin"]);

/** Whether the editor can show the file at all. */
export function isText(path: string): boolean {
  const ending = endingOf(path);
  return !PICTURE_ENDINGS.has(ending) && !BINARY_ENDINGS.has(ending);
}
