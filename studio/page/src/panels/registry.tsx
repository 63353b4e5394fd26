import type { ComponentType, JSX } from "preact";
import type { PanelName } from "../core/layout.js";
import * as state from "../state.js";
import { AnimationPanel } from "./animation.js";
import { ConsolePanel } from "./console.js";
import { FarmPanel } from "./farm.js";
import { FilesPanel } from "./files.js";
import { GraphsPanel } from "./graphs.js";
import { ModelsPanel } from "./models.js";
import { ProblemsPanel } from "./problems.js";
import { PropertiesPanel } from "./properties.js";
import { ScenePanel } from "./scene.js";
import { ScriptPanel } from "./script.js";
import { ViewPanel } from "./view.js";

const PANELS: Record<PanelName, ComponentType> = {
  Files: FilesPanel,
  Models: ModelsPanel,
  Script: ScriptPanel,
  View: ViewPanel,
  Scene: ScenePanel,
  Properties: PropertiesPanel,
  Problems: ProblemsPanel,
  Console: ConsolePanel,
  Graphs: GraphsPanel,
  Farm: FarmPanel,
  Animation: AnimationPanel,
};

export function panelOf(name: PanelName): ComponentType {
  return PANELS[name];
}

/** What a tab says of its panel beside its name. */
export function badgeOf(name: PanelName): JSX.Element | null {
  if (name !== "Problems" || state.problems.value.length === 0) return null;
  const errors = state.problems.value.some((each) => each.severity === "error");
  return <span class={`badge ${errors ? "error" : "warning"}`}>{state.problems.value.length}</span>;
}
