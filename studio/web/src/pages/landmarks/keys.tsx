// The small table that names the keys of the page.
export function KeysHelp({ keys }: { keys: [string, string][] }) {
  return (
    <details class="lm-menu lm-keys">
      <summary>Keys</summary>
      <dl>
        {keys.map(([key, what]) => (
          <>
            <dt>
              <kbd>{key}</kbd>
            </dt>
            <dd>{what}</dd>
          </>
        ))}
      </dl>
    </details>
  )
}
