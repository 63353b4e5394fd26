// Numbers for people.

export function duration(seconds) {
  if (seconds == null) return "";
  if (seconds < 0.0995) return `${(seconds * 1000).toPrecision(2)} ms`;
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  if (seconds < 60) return `${Math.round(seconds)} s`;
  const whole = Math.round(seconds);
  const two = (n) => String(n).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes}:${two(whole % 60)}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

export function bytes(count) {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let unit = 0;
  while (count >= 999.5 && unit < units.length - 1) {
    count /= 1000;
    ++unit;
  }
  return `${unit === 0 || count >= 99.5 ? Math.round(count) : count.toPrecision(2)} ${units[unit]}`;
}

export function counted(count, thing) {
  return `${count.toLocaleString("en")} ${thing}${count === 1 ? "" : "s"}`;
}

export function rate(perSecond) {
  return perSecond >= 10 || perSecond === 0 ? Math.round(perSecond).toLocaleString("en") : perSecond.toFixed(1);
}

/// A colour of its own for each worker, the same on every page.
export function workerColor(id) {
  let hash = 2166136261;
  for (const letter of id) hash = Math.imul(hash ^ letter.charCodeAt(0), 16777619) >>> 0;
  return `hsl(${(hash % 360)} 70% ${45 + (hash >>> 12) % 18}%)`;
}
