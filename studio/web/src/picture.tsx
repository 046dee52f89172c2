// A picture of the project, or words in its place where there is none that can be shown.
import { useState } from 'preact/hooks'
import type { JSX } from 'preact'

/** As <img>; a file that was damaged or taken away meanwhile leaves no broken picture. */
export function Picture(props: JSX.IntrinsicElements['img']) {
  const [broken, setBroken] = useState('')
  if (broken !== '' && broken === props.src)
    return (
      <span class="no-picture small" title={props.title ?? props.alt}>
        cannot be read
      </span>
    )
  return <img {...props} onError={() => setBroken(String(props.src))} />
}
