// Numbers for people.

export function duration(seconds) {
  if (seconds == null) return "";
  if (seconds < 0.00995) return `${(seconds * 1000).toFixed(1)} ms`;
  if (seconds < 0.9995) return `${Math.round(seconds * 1000)} ms`;
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  if (seconds < 60) return `${Math.round(seconds)} s`;
  const whole = Math.round(seconds);
  const two = (n) => String(n).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes}:${two(whole % 60)}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

/// Local time to the second, with date and zone, as ISO 8601 has it.
export function localTime(date) {
  const zone = -date.getTimezoneOffset(), ahead = Math.abs(zone);
  const two = (n) => String(n).padStart(2, "0");
  const local = new Date(date.getTime() + zone * 60000).toISOString().slice(0, 19);
  return `${local}${zone < 0 ? "-" : "+"}${two(Math.floor(ahead / 60))}:${two(ahead % 60)}`;
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

const places = new Map();

/// A colour for each worker, as far as possible from those of the workers before it.
export function workerColor(id) {
  if (!places.has(id)) places.set(id, places.size);
  const place = places.get(id);
  return `hsl(${Math.round(205 + place * 137.508) % 360} 68% ${[50, 42, 58][Math.floor(place / 8) % 3]}%)`;
}
