import type { ComponentChildren } from "preact";
import { useLayoutEffect } from "preact/hooks";
import { move, PANELS, type PanelName, type ZoneName } from "../core/layout.js";
import { panelOf, badgeOf } from "../panels/registry.js";
import { layout, narrow, onlyPanel, showPanel, takeFocus } from "./layout_state.js";
import { Splitter } from "./splitter.js";

/** What a tab that is dragged has with it. */
const DRAGGED = "application/x-tessera-panel";

function Tabs({ tabs, shown }: { tabs: readonly PanelName[]; shown: PanelName | undefined }) {
  const key = (event: KeyboardEvent, index: number) => {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    const next = tabs[(index + step + tabs.length) % tabs.length]!;
    showPanel(next);
    const list = (event.currentTarget as HTMLElement).parentElement!;
    requestAnimationFrame(() => list.querySelector<HTMLElement>('[aria-selected="true"]')?.focus());
    event.preventDefault();
  };
  return (
    <div class="tabs" role="tablist">
      {tabs.map((panel, index) => (
        <button
          key={panel}
          type="button"
          role="tab"
          class="tab"
          draggable
          data-panel={panel}
          aria-selected={panel === shown}
          tabIndex={panel === shown ? 0 : -1}
          onClick={() => showPanel(panel)}
          onKeyDown={(event) => key(event, index)}
          onDragStart={(event) => event.dataTransfer?.setData(DRAGGED, panel)}
        >
          {panel}
          {badgeOf(panel)}
        </button>
      ))}
    </div>
  );
}

function Body({ panel }: { panel: PanelName | undefined }) {
  useLayoutEffect(() => panel && takeFocus(panel), [panel]);
  if (!panel) return null;
  const Panel = panelOf(panel);
  return (
    <section class={`panel panel-${panel.toLowerCase()}`} aria-label={panel} tabIndex={-1} key={panel}>
      <Panel />
    </section>
  );
}

function Zone({ name, share, children }: { name: ZoneName; share?: string; children?: ComponentChildren }) {
  const zone = layout.value.zones[name];
  const over = (event: DragEvent) => {
    if (event.dataTransfer?.types.includes(DRAGGED)) event.preventDefault();
  };
  const drop = (event: DragEvent) => {
    const panel = PANELS.find((each) => each === event.dataTransfer?.getData(DRAGGED));
    if (!panel) return;
    layout.value = move(layout.peek(), panel, name);
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div class={`zone zone-${name}`} style={share ? { flexBasis: share } : undefined} onDragOverCapture={over} onDropCapture={drop}>
      <Tabs tabs={zone.tabs} shown={zone.shown} />
      <Body panel={zone.shown} />
      {children}
    </div>
  );
}

const percent = (share: number) => `${(share * 100).toFixed(2)}%`;

/** All zones, or one row of tabs where there is no room for them. */
export function Zones() {
  const { zones, shares, maximised } = layout.value;
  if (narrow.value) {
    return (
      <div class="zones narrow">
        <Tabs tabs={PANELS} shown={onlyPanel.value} />
        <Body panel={onlyPanel.value} />
      </div>
    );
  }
  if (maximised && zones[maximised].tabs.length > 0) {
    return (
      <div class="zones">
        <Zone name={maximised} />
      </div>
    );
  }
  const has = (name: ZoneName) => zones[name].tabs.length > 0;
  const hasRight = has("top") || has("low");
  return (
    <div class="zones">
      <div class="columns">
        {has("left") && <Zone name="left" share={hasRight || has("middle") ? percent(shares.left) : "100%"} />}
        {has("left") && (has("middle") || hasRight) && <Splitter share="left" label="Width of the left" vertical />}
        {has("middle") && <Zone name="middle" share={hasRight ? percent(shares.middle) : "100%"} />}
        {has("middle") && hasRight && <Splitter share="middle" label="Width of the script" vertical />}
        {hasRight && (
          <div class="right">
            {has("top") && <Zone name="top" share={has("low") ? percent(shares.top) : "100%"} />}
            {has("top") && has("low") && <Splitter share="top" label="Height of the view" vertical={false} />}
            {has("low") && <Zone name="low" />}
          </div>
        )}
      </div>
      {has("bottom") && <Splitter share="bottom" label="Height of the bottom" vertical={false} />}
      {has("bottom") && <Zone name="bottom" share={percent(shares.bottom)} />}
    </div>
  );
}
