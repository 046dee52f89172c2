// A large picture that is opened over the page: contact sheets, by a word or by a small one of it.
import type { ComponentChildren } from 'preact'
import { useRef } from 'preact/hooks'

import { api } from './api'
import type { FailurePicture } from './api'

export function Sheet(props: {
  src: string
  title: string
  /** what it shows, for people who do not see it */
  alt: string
  /** within the button that opens it */
  children: ComponentChildren
  className?: string
}) {
  const dialog = useRef<HTMLDialogElement>(null)
  return (
    <>
      <button class={props.className ?? 'quiet small'} onClick={() => dialog.current!.showModal()}>
        {props.children}
      </button>
      <dialog ref={dialog} class="sheet-dialog" aria-label={props.title}>
        <form method="dialog" class="row spread">
          <h2>{props.title}</h2>
          <button>Close</button>
        </form>
        <div class="scrolls" tabIndex={0}>
          <img src={props.src} alt={props.alt} loading="lazy" />
        </div>
      </dialog>
    </>
  )
}

const kTaken = 'What was taken for the figure'

/** The picture that a step left when it failed, small; a click shows it large. */
export function FailureSheet(props: { picture: FailurePicture; figure: boolean }) {
  const title = props.figure ? kTaken : 'What the step saw'
  return (
    <Sheet
      src={api.failedUrl(props.picture)}
      title={title}
      alt={props.figure ? 'Every photograph; what was not taken for the figure is purple' : title}
      className="sheet-small"
    >
      <img src={api.failedUrl(props.picture, 480)} alt="" />
      <span class="small">{title}</span>
    </Sheet>
  )
}
