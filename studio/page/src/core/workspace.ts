// What is open in a folder and from where it is seen, as the program keeps it.

import type { CameraWish, FreeCamera, Vector, Workspace } from "./protocol.js";

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isVector(value: unknown): value is Vector {
  return Array.isArray(value) && value.length === 3 && value.every((each) => Number.isFinite(each));
}

function isFreeCamera(value: Record<string, unknown>): boolean {
  const { eye, target, up, fov, axis, orthographic, name } = value;
  return (
    isVector(eye) &&
    isVector(target) &&
    isVector(up) &&
    typeof fov === "number" &&
    fov > 0 &&
    fov < 180 &&
    (axis === undefined || typeof axis === "string") &&
    (orthographic === undefined || Number.isFinite(orthographic)) &&
    (name === undefined || typeof name === "string")
  );
}

function cameraOf(value: unknown): CameraWish {
  if (!isObject(value)) return null;
  if ("eye" in value) return isFreeCamera(value) ? (value as unknown as FreeCamera) : null;
  return typeof value.name === "string" ? { name: value.name } : null;
}

function entries<T>(value: unknown, read: (each: unknown) => T | undefined): Record<string, T> {
  const found: [string, T][] = [];
  for (const [file, each] of isObject(value) ? Object.entries(value) : []) {
    const known = read(each);
    if (known !== undefined) found.push([file, known]);
  }
  return Object.fromEntries(found);
}

function selectionOf(value: unknown): [number, number] | undefined {
  const isOne = Array.isArray(value) && value.length === 2 && value.every((each) => Number.isSafeInteger(each) && each >= 0);
  return isOne ? (value as [number, number]) : undefined;
}

function viewOf(value: unknown): { cameras: CameraWish[]; pivot?: Vector } | undefined {
  if (!isObject(value) || !Array.isArray(value.cameras)) return undefined;
  return { cameras: value.cameras.map(cameraOf), ...(isVector(value.pivot) ? { pivot: value.pivot } : {}) };
}

/** What was kept, without what makes no sense: its file may have been written by anyone. */
export function keptWorkspace(value: unknown): Required<Pick<Workspace, "open" | "selections" | "views">> & Workspace {
  const kept = isObject(value) ? value : {};
  const open = Array.isArray(kept.open) ? kept.open.filter((each): each is string => typeof each === "string") : [];
  const file = (name: "active" | "scene") => (open.includes(kept[name] as string) ? { [name]: kept[name] as string } : {});
  return {
    open: [...new Set(open)],
    ...file("active"),
    ...file("scene"),
    selections: entries(kept.selections, selectionOf),
    views: entries(kept.views, viewOf),
  };
}
