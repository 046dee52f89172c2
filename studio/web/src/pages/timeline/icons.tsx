// Signs of the transport, drawn in the text's colour.

const kPaths = {
  play: 'M4.5 2.5v11l9-5.5z',
  pause: 'M4 2.5h3v11H4zM9 2.5h3v11H9z',
  back: 'M11.5 3v10L4.5 8zM3 3h1.2v10H3z',
  forward: 'M4.5 3v10l7-5zM11.8 3H13v10h-1.2z',
  first: 'M2.5 3H4v10H2.5zM9 3v10L4.2 8zM14 3v10L9.2 8z',
  last: 'M12 3h1.5v10H12zM7 3v10l4.8-5zM2 3v10l4.8-5z',
  undo: 'M6.5 3 2.5 6.5l4 3.5V7.7h3a2.3 2.3 0 0 1 0 4.6H6v1.5h3.5a3.8 3.8 0 0 0 0-7.6h-3z',
  redo: 'M9.5 3l4 3.5-4 3.5V7.7h-3a2.3 2.3 0 0 0 0 4.6H10v1.5H6.5a3.8 3.8 0 0 1 0-7.6h3z',
  repeat: 'M4 4.5h6.5V2.5L14 5.3l-3.5 2.8V6H5.5v2.5H4zM12 11.5H5.5v2L2 10.7l3.5-2.8V10h5V7.5H12z',
  onion:
    'M6 3a5 5 0 1 0 0 10A5 5 0 0 0 6 3zm0 1.3a3.7 3.7 0 1 1 0 7.4 3.7 3.7 0 0 1 0-7.4z' +
    'M10 3a5 5 0 1 1-1.9 9.6l.9-1a3.7 3.7 0 1 0 0-7.2l-.9-1A5 5 0 0 1 10 3z',
  sound: 'M2.5 6h2.7L9 3v10L5.2 10H2.5zM10.5 5.5a3.5 3.5 0 0 1 0 5v-1.7a2 2 0 0 0 0-1.6z',
  mute:
    'M2.5 6h2.7L9 3v10L5.2 10H2.5z' +
    'M10.3 6.3l1-1 1.2 1.3 1.2-1.3 1 1L13.4 7.6l1.3 1.3-1 1-1.2-1.3-1.2 1.3-1-1 1.3-1.3z',
  bin: 'M6 2.5h4l.5 1H13v1.3H3V3.5h2.5zM4 5.8h8l-.6 7.7H4.6z',
  copy: 'M5.5 2.5h8v8h-2v3h-9v-8h3zm1.3 3h4.7v3.7h.7V3.8H6.8zM3.8 6.8v5.4h6.4V6.8z',
  plus: 'M7.3 3h1.4v4.3H13v1.4H8.7V13H7.3V8.7H3V7.3h4.3z',
} as const

export type IconName = keyof typeof kPaths

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" width="16" height="16" aria-hidden="true">
      <path d={kPaths[name]} fill="currentColor" fill-rule="evenodd" />
    </svg>
  )
}
