// Pieces that both benches of the page have: pairs on two meshes, and in photographs.

/** Renames or deletes the pair of a row. */
export function RowTools(props: { name: string; rename: () => void; remove: () => void }) {
  return (
    <span class="lm-tools">
      <button
        class="quiet"
        aria-label={`Rename ${props.name}`}
        title="Rename (F2)"
        onClick={props.rename}
      >
        ✎
      </button>
      <button
        class="quiet"
        aria-label={`Delete ${props.name}`}
        title="Delete (Del)"
        onClick={props.remove}
      >
        ×
      </button>
    </span>
  )
}

/** With the clay's colours, or the shape alone. */
export function LookChoice(props: { plain: boolean; change: (plain: boolean) => void }) {
  const look = (plain: boolean, name: string, title: string) => (
    <button
      aria-pressed={props.plain === plain}
      title={title}
      onClick={() => props.change(plain)}
    >
      {name}
    </button>
  )
  return (
    <span class="choice" role="group" aria-label="Look">
      {look(false, 'Textured', "With the clay's colours (P)")}
      {look(true, 'Plain', 'Only the shape (P)')}
    </span>
  )
}
