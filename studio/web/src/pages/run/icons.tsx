// Small signs, so that no state is told by colour alone. Drawn, as fonts differ in their glyphs.
const kPaths: Record<string, string> = {
  done: 'M3 8.5 6.5 12 13 4.5',
  would_run: 'M13 8a5 5 0 1 1-1.6-3.7M13 2.5v3h-3',
  waits: 'M8 4.5V8l2.5 1.8M14 8A6 6 0 1 1 2 8a6 6 0 0 1 12 0',
  failed: 'M4 4l8 8M12 4l-8 8',
  never: 'M4 8h8',
  missing: 'M4 8h.01M8 8h.01M12 8h.01',
  running: 'M5.5 3.5v9l7-4.5z',
  warning: 'M8 2.5 14 13H2zM8 6.5v3M8 11.4v.1',
  good: 'M3 8.5 6.5 12 13 4.5',
  look:
    'M1.5 8S4 3.8 8 3.8 14.5 8 14.5 8 12 12.2 8 12.2 1.5 8 1.5 8' +
    'M7 8a1 1 0 1 0 2 0 1 1 0 0 0-2 0',
  wrong: 'M4 4l8 8M12 4l-8 8',
  download: 'M8 2.5v8M4.5 7 8 10.5 11.5 7M3 13.5h10',
  folder: 'M2 12.5v-9h4l1.5 2H14v7z',
  arrow: 'M2.5 8h10M9 4.5 12.5 8 9 11.5',
  search: 'M11 11l3 3M12 7a5 5 0 1 1-10 0 5 5 0 0 1 10 0',
  undo: 'M3 6.5h6.5a3.5 3.5 0 0 1 0 7H6M5.5 4 3 6.5 5.5 9',
}

export function Icon({ name }: { name: string }) {
  return (
    <svg
      class={`icon-${name}`}
      width="14"
      height="14"
      viewBox="0 0 16 16"
      fill={name === 'running' ? 'currentColor' : 'none'}
      stroke="currentColor"
      stroke-width="1.8"
      stroke-linecap="round"
      stroke-linejoin="round"
      aria-hidden="true"
    >
      <path d={kPaths[name] ?? kPaths.missing} />
    </svg>
  )
}
