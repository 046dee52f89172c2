import { useRef } from 'preact/hooks'

import { chosen, kAccept } from './files'
import type { Found } from './files'

/** A button that opens the browser's own dialog for files or for a folder. */
export function Chooser(props: {
  folder: boolean
  words: string
  label?: string
  /** endings that the dialog offers; photographs' unless said */
  accept?: string
  add: (found: Found[]) => void
}) {
  const input = useRef<HTMLInputElement>(null)
  return (
    <>
      <button onClick={() => input.current!.click()} aria-label={props.label}>
        {props.words}
      </button>
      <input
        ref={input}
        type="file"
        multiple
        hidden
        accept={props.folder ? undefined : (props.accept ?? kAccept)}
        {...(props.folder ? { webkitdirectory: true } : {})}
        onChange={(event) => {
          props.add(chosen(event.currentTarget.files))
          event.currentTarget.value = '' // the same folder can be chosen again
        }}
      />
    </>
  )
}
