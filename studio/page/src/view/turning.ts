// Lights and backgrounds moved and turned by dragging over the picture: one edit of the text, and one step of undo, a drag.

import { draggable, draggedText, type PictureDrag } from "../core/turning.js";
import { titleOf } from "../core/entities.js";
import type { Field } from "../core/protocol.js";
import { beginGesture, select, selected, setField } from "../entities.js";
import * as state from "../state.js";
import { axesOf } from "./filter.js";
import { currentCamera } from "./wish.js";

/** The field as it was when the drag began. */
let dragged: { entity: string; field: Field } | undefined;
/** Whether lights that have a place are turned there. */
let turns = false;

/** The field of the entity that is selected, once the program has told its fields. */
function fieldOfSelected(): { entity: string; field: Field } | undefined {
  const { value: fields } = state.fields;
  const entity = selected.peek();
  if (!fields || !entity || fields.entity !== entity.id) return undefined;
  const field = draggable({ fields: fields.fields, isLight: entity.kind === "light", turns });
  return field && { entity: entity.id, field };
}

/** Whether it was said of this drag that it turns nothing. */
let isToldFixed = false;

/** Says once a drag that what is selected cannot be turned, where the program has told its fields. */
function tellFixed(): void {
  const entity = selected.peek();
  if (isToldFixed || !entity || state.fields.peek()?.entity !== entity.id) return;
  isToldFixed = true;
  state.notify(entity.kind === "background" ? "This background has no direction to turn: a colour or a gradient is the same all around." : `${titleOf(entity)} has no place or direction that a drag changes.`);
}

/** The light that is selected is moved or turned, or else the background is turned. */
export function beginDrag(turnsLights: boolean): void {
  turns = turnsLights;
  isToldFixed = false;
  beginGesture();
  dragged = fieldOfSelected();
  if (dragged) return;
  const background = state.outline.peek()?.entities.find((each) => each.kind === "background");
  if (!background) state.notify("Select a light, or give the scene a background that can be turned.");
  else if (selected.peek() !== background) select(background, false);
}

/** So far from where the drag began. */
export function dragTo(pane: state.Pane, drag: PictureDrag): void {
  dragged ??= fieldOfSelected();
  if (!dragged) tellFixed();
  const camera = currentCamera(pane);
  const outline = state.outline.peek();
  const axes = dragged && outline && axesOf(outline.file, outline.entities, dragged.entity);
  const text = dragged && camera ? draggedText(dragged.field, camera, drag, axes) : undefined;
  if (text !== undefined) setField(dragged!.entity, dragged!.field.name, text);
}

export function endDrag(): void {
  dragged = undefined;
}
